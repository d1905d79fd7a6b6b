#include "core/geometry/zones.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/geometry/distances.hpp"

namespace fairlead {
namespace {

// An edge of a counter-clockwise polygon.
class Edge {
 public:
  Edge(const Polygon& polygon, std::size_t i)
      : from_(polygon[i]),
        along_x_(polygon[(i + 1) % polygon.size()][0] - from_[0]),
        along_y_(polygon[(i + 1) % polygon.size()][1] - from_[1]),
        length_(std::hypot(along_x_, along_y_)) {}

  /// How far a point is on its outer side.
  [[nodiscard]] double outside(const Corner& point) const {
    return (along_y_ * (point[0] - from_[0]) - along_x_ * (point[1] - from_[1])) / length_;
  }

 private:
  const Corner& from_;
  double along_x_, along_y_, length_;
};

// The edge of one polygon that has the whole other one furthest on its outer side.
double best_edge(const Polygon& one, const Polygon& other) {
  double best = -std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < one.size(); ++i) {
    const Edge edge(one, i);
    double nearest = std::numeric_limits<double>::infinity();
    for (const Corner& corner : other) nearest = smaller(nearest, edge.outside(corner));
    best = larger(best, nearest);
  }
  return best;
}

double margin_of(const Zone& zone, const Polygon& footprint) {
  return zone.keep_out ? separation(footprint, zone.corners) : inside(footprint, zone.corners);
}

}  // namespace

double separation(const Polygon& one, const Polygon& other) {
  return larger(best_edge(one, other), best_edge(other, one));
}

double inside(const Polygon& corners, const Polygon& zone) {
  double nearest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < zone.size(); ++i) {
    const Edge edge(zone, i);
    for (const Corner& corner : corners) nearest = smaller(nearest, -edge.outside(corner));
  }
  return nearest;
}

// At zero the root link and odom are one; the slides carry the axis that the yaw turns about.
Polygon footprint_at(const BaseLimits& base, const Joints& joints) {
  const double x = joints[base.joints[0]], y = joints[base.joints[1]];
  const double cosine = std::cos(joints[base.joints[2]]);
  const double sine = std::sin(joints[base.joints[2]]);
  Polygon corners;
  for (const Corner& corner : base.footprint) {
    const double from_x = corner[0] - base.yaw_axis[0], from_y = corner[1] - base.yaw_axis[1];
    (void)corners.push_back({base.yaw_axis[0] + x + cosine * from_x - sine * from_y,
                             base.yaw_axis[1] + y + sine * from_x + cosine * from_y});
  }
  return corners;
}

double base_way(const RobotModel& model, const Joints& from, const Joints& to) {
  Joints ways;
  for (const std::size_t j : model.limits.base.joints) ways[j] = std::abs(to[j] - from[j]);
  return base_way(model, ways);
}

double base_way(const RobotModel& model, const Joints& ways) {
  const auto& joints = model.limits.base.joints;
  return ways[joints[0]] + ways[joints[1]] + model.base_extent * ways[joints[2]];
}

Evidence check_base(const RobotModel& model, const Joints& joints, const Joints& before,
                    const BaseOff& off, double& slack) {
  const BaseLimits& base = model.limits.base;
  const Polygon here = footprint_at(base, joints);
  slack = std::numeric_limits<double>::infinity();
  for (const Zone& zone : base.zones) {
    const double margin = margin_of(zone, here) - off.now;
    slack = std::min(slack, std::max(margin, 0.0));
    const auto margin_before = [&] {
      return margin_of(zone, footprint_at(base, before)) - off.before;
    };
    if (!is_breach(margin, margin_before)) continue;
    return of(below(code::zone, zone.name.view(), margin, 0.0, "m", base.source.view()),
              model.limits.parts[model.limits.joints[base.joints[0]].part].name);
  }
  return {};
}

}  // namespace fairlead
