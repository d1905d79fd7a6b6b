#include "core/geometry/distances.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "fairlead_safety/geometry_limits.hpp"

namespace fairlead {
namespace {

// Segments whose directions differ by a sine of less than 1e-7 count as parallel: what that
// misses is below a ten-millionth of their length.
constexpr double parallel = 1e-14;

double within_one(double share) { return std::clamp(share, 0.0, 1.0); }

// How far a coordinate lies outside its range, signed; what compares with nothing is nowhere.
double beyond(double x, double lower, double upper) {
  return std::max(x - upper, 0.0) + std::min(x - lower, 0.0);
}

Eigen::Vector3d outside(const Eigen::Vector3d& point, const Box& box) {
  return {beyond(point.x(), box.lower.x(), box.upper.x()),
          beyond(point.y(), box.lower.y(), box.upper.y()),
          beyond(point.z(), box.lower.z(), box.upper.z())};
}

// The square of the distance from the box is convex along a segment, its slope linear between the
// shares at which a coordinate crosses a face: the lowest point lies where the slope changes sign,
// or at an end.
double lowest_share(const Segment& segment, const Box& box) {
  const Eigen::Vector3d along = segment.b - segment.a;
  const auto slope = [&](double share) {
    return along.dot(outside(segment.a + share * along, box));
  };
  double low = 0.0, high = 1.0;
  double slope_low = slope(low), slope_high = slope(high);
  for (Eigen::Index i = 0; i < 3; ++i) {
    for (const double face : {box.lower[i], box.upper[i]}) {
      // Along a face the segment crosses it nowhere, or everywhere: the low end will do.
      const double share = std::fmin(std::fmax((face - segment.a[i]) / along[i], low), high);
      const double here = slope(share);
      const bool falls = std::signbit(here);
      (falls ? low : high) = share;
      (falls ? slope_low : slope_high) = here;
    }
  }
  const double rise = std::max(slope_high - slope_low, std::numeric_limits<double>::min());
  return low + (high - low) * within_one(-slope_low / rise);
}

// How far a segment lies beyond each upper face with all of it, then each lower one.
Eigen::Matrix<double, 6, 1> beyond_faces(const Segment& segment, const Box& box) {
  Eigen::Matrix<double, 6, 1> beyond;
  beyond << segment.a.cwiseMin(segment.b) - box.upper, box.lower - segment.a.cwiseMax(segment.b);
  return beyond;
}

Eigen::Vector3d box_gap(const Segment& segment, const Box& box) {
  return outside(segment.a + lowest_share(segment, box) * (segment.b - segment.a), box);
}

}  // namespace

// The nearest points of the two lines, then moved back to the ends of the segments.
Eigen::Vector3d segment_gap(const Segment& one, const Segment& other) {
  const Eigen::Vector3d d1 = one.b - one.a;
  const Eigen::Vector3d d2 = other.b - other.a;
  const Eigen::Vector3d from = one.a - other.a;
  const double a = d1.squaredNorm(), e = d2.squaredNorm();
  const double b = d1.dot(d2), c = d1.dot(from), f = d2.dot(from);
  const double turned = a * e - b * b;
  double s{}, t{};  // where any will do: of parallel ones, of points
  if (turned > parallel * a * e) s = within_one((b * f - c * e) / turned);
  if (e > 0.0) t = within_one((b * s + f) / e);
  // For the point found on the other one, the nearest of this one.
  if (a > 0.0) s = within_one((b * t - c) / a);
  return from + s * d1 - t * d2;
}

Eigen::Vector3d box_direction(const Segment& segment, const Box& box) {
  const Eigen::Vector3d gap = box_gap(segment, box);
  if (!gap.isZero(0.0)) return gap.normalized();
  Eigen::Index face = 0;
  beyond_faces(segment, box).maxCoeff(&face);
  return (face < 3 ? 1.0 : -1.0) * Eigen::Vector3d::Unit(face % 3);
}

double box_distance(const Segment& segment, const Box& box) {
  for (Eigen::Index i = 0; i < 3; ++i)
    if (!(box.lower[i] <= box.upper[i])) return unset;
  const double distance = box_gap(segment, box).norm();
  return distance > 0.0 || std::isnan(distance) ? distance : beyond_faces(segment, box).maxCoeff();
}

}  // namespace fairlead
