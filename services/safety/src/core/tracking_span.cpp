// The four points lie in one plane (through the origin), so what is between them is two triangles.

#include "tracking_span.hpp"

#include <Eigen/Geometry>
#include <algorithm>

namespace fairlead {
namespace {

using Point = Eigen::Vector3d;

// The smaller one; NaN if either is.
double lesser(double a, double b) {
  if (a <= b) return a;
  return b < a ? b : unset;
}

double to_segment(const Point& p, const Point& a, const Point& b) {
  const Point along = b - a;
  const double length = along.squaredNorm();
  const double share = length > 0.0 ? std::clamp((p - a).dot(along) / length, 0.0, 1.0) : 0.0;
  return (p - a - share * along).norm();
}

double to_triangle(const Point& p, const Point& a, const Point& b, const Point& c) {
  const double edge = lesser(to_segment(p, a, b), lesser(to_segment(p, b, c), to_segment(p, c, a)));
  const Point normal = (b - a).cross(c - a);
  // A sliver is as good as its edges, and its normal is noise.
  constexpr double sliver = 1e-18;
  if (!(normal.squaredNorm() > sliver * (b - a).squaredNorm() * (c - a).squaredNorm())) return edge;
  const bool above_it = (b - a).cross(p - a).dot(normal) >= 0.0 &&
                        (c - b).cross(p - b).dot(normal) >= 0.0 &&
                        (a - c).cross(p - c).dot(normal) >= 0.0;
  return above_it ? std::abs(normal.dot(p - a)) / normal.norm() : edge;
}

}  // namespace

double TrackingSpan::distance(const Eigen::Vector3d& motion) const {
  return lesser(to_triangle(motion, from, slow, fast), to_triangle(motion, from, from_too, fast));
}

}  // namespace fairlead
