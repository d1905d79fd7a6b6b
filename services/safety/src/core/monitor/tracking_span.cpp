// The four points lie in one plane (through the origin), so what is between them is two triangles.

#include "core/monitor/tracking_span.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

namespace fairlead {
namespace {

using Point = Eigen::Vector3d;

// The smaller one; NaN if either is.
double lesser(double a, double b) {
  return std::isnan(a) || std::isnan(b) ? unset : std::min(a, b);
}

double to_segment(const Point& p, const Point& a, const Point& b) {
  const Point along = b - a;
  const double length = along.squaredNorm();
  double share{};  // of a point any will do
  if (length > 0.0) share = std::clamp((p - a).dot(along) / length, 0.0, 1.0);
  return (p - a - share * along).norm();
}

double to_triangle(const Point& p, const Point& a, const Point& b, const Point& c) {
  const double edge = lesser(to_segment(p, a, b), lesser(to_segment(p, b, c), to_segment(p, c, a)));
  const Point one = b - a, other = c - a;
  const Point normal = one.cross(other);
  // A sliver is as good as its edges, and its normal is noise.
  constexpr double sliver = std::numeric_limits<double>::epsilon();
  if (!(normal.squaredNorm() > sliver * one.squaredNorm() * other.squaredNorm())) return edge;
  const auto outside = [&](const Point& from, const Point& to) {
    return std::signbit((to - from).cross(p - from).dot(normal));
  };
  if (outside(a, b) || outside(b, c) || outside(c, a)) return edge;
  return std::abs(normal.dot(p)) / normal.norm();
}

}  // namespace

double TrackingSpan::distance(const Eigen::Vector3d& motion) const {
  return lesser(to_triangle(motion, from, slow, fast), to_triangle(motion, from, from_too, fast));
}

}  // namespace fairlead
