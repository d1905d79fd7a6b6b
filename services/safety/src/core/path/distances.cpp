#include "distances.hpp"

#include <algorithm>
#include <cmath>

#include "fairlead_safety/geometry_limits.hpp"

namespace fairlead {
namespace {

// Segments whose directions differ by a sine of less than 1e-7 count as parallel: what that
// misses is below a ten-millionth of their length.
constexpr double parallel = 1e-14;

double within_one(double share) { return share < 0.0 ? 0.0 : share > 1.0 ? 1.0 : share; }

// How far a coordinate lies outside its range, signed; what compares with nothing is nowhere.
double beyond(double x, double lower, double upper) {
  if (x <= upper && x >= lower) return 0.0;
  return x > upper ? x - upper : x < lower ? x - lower : unset;
}

Eigen::Vector3d outside(const Eigen::Vector3d& point, const Box& box) {
  return {beyond(point.x(), box.lower.x(), box.upper.x()),
          beyond(point.y(), box.lower.y(), box.upper.y()),
          beyond(point.z(), box.lower.z(), box.upper.z())};
}

// The square of the distance from the box is convex along a segment, its slope linear between the
// shares at which a coordinate crosses a face: the lowest point lies where the slope changes sign.
double lowest_share(const Segment& segment, const Box& box) {
  const Eigen::Vector3d along = segment.b - segment.a;
  const auto slope = [&](double share) {
    return along.dot(outside(segment.a + share * along, box));
  };
  double low = 0.0, high = 1.0;
  double slope_low = slope(low), slope_high = slope(high);
  if (slope_low >= 0.0) return low;
  if (slope_high <= 0.0) return high;
  for (Eigen::Index i = 0; i < 3; ++i) {
    for (const double face : {box.lower[i], box.upper[i]}) {
      const double share = (face - segment.a[i]) / along[i];
      if (!(share > low && share < high)) continue;
      const double here = slope(share);
      (here < 0.0 ? low : high) = share;
      (here < 0.0 ? slope_low : slope_high) = here;
    }
  }
  return low + (high - low) * slope_low / (slope_low - slope_high);
}

// How deep a segment lies behind the face it is nearest to have left: negative.
double depth(const Segment& segment, const Box& box) {
  const Eigen::Vector3d above = segment.a.cwiseMin(segment.b) - box.upper;
  const Eigen::Vector3d below = box.lower - segment.a.cwiseMax(segment.b);
  return std::max(above.maxCoeff(), below.maxCoeff());
}

}  // namespace

// The nearest points of the two lines, then moved back to the ends of the segments.
double segment_distance(const Segment& one, const Segment& other) {
  const Eigen::Vector3d d1 = one.b - one.a;
  const Eigen::Vector3d d2 = other.b - other.a;
  const Eigen::Vector3d from = one.a - other.a;
  const double a = d1.squaredNorm(), e = d2.squaredNorm();
  const double b = d1.dot(d2), c = d1.dot(from), f = d2.dot(from);
  const double turned = a * e - b * b;
  double s = turned > parallel * a * e ? within_one((b * f - c * e) / turned) : 0.0;
  const double t = e > 0.0 ? within_one((b * s + f) / e) : 0.0;
  // For the point found on the other one, the nearest of this one.
  s = a > 0.0 ? within_one((b * t - c) / a) : 0.0;
  return (from + s * d1 - t * d2).norm();
}

double box_distance(const Segment& segment, const Box& box) {
  for (Eigen::Index i = 0; i < 3; ++i)
    if (!(box.lower[i] <= box.upper[i])) return unset;
  const double share = lowest_share(segment, box);
  const double distance = outside(segment.a + share * (segment.b - segment.a), box).norm();
  return distance > 0.0 || std::isnan(distance) ? distance : depth(segment, box);
}

}  // namespace fairlead
