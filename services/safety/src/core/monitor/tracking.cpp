#include "core/monitor/tracking.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/chunk/state_check.hpp"
#include "core/modes/commanded_motion.hpp"
#include "fairlead_safety/limits.hpp"

namespace fairlead {
namespace {

// A limit of its own, measured or decided as the mode's source says.
Evidence within(std::string_view axis, double distance, double limit, std::string_view unit,
                std::string_view key) {
  if (distance <= limit) return {};
  return declared_as(above(code::tracking, axis, distance, limit, unit, key), key);
}

struct HalfNames {
  std::string_view linear_unit, linear_key, angular_unit, angular_key;
};
constexpr HalfNames in_a_tick{"m", "linear_tracking_m", "rad", "angular_tracking_rad"};
constexpr HalfNames in_a_second{"m/s", "linear_tracking_m_s", "rad/s", "angular_tracking_rad_s"};

Evidence halves_within(double linear, double linear_limit, double angular, double angular_limit,
                       const HalfNames& names) {
  const Evidence evidence =
      within("linear", linear, linear_limit, names.linear_unit, names.linear_key);
  if (!evidence.ok()) return evidence;
  return within("angular", angular, angular_limit, names.angular_unit, names.angular_key);
}

// A servo lags behind its target: the limit is declared to include it.
Evidence check_targets(const MotionView& view) {
  const JointModeLimits& mode = *joint_block(view.modes, view.mode());
  for (const std::uint8_t j : view.now.action->active) {
    const JointLimits& joint = view.limits.joints[j];
    const double error = std::abs(measured_change(joint, view.now[j], view.state.positions[j]));
    const Evidence evidence = within(joint.name.view(), error, mode.tracking[j],
                                     position_unit(joint.kind), "tracking_limits");
    if (!evidence.ok()) return evidence;
  }
  return {};
}

// A joint that the row before left alone held in it.
Evidence check_velocities(const MotionView& view) {
  const JointModeLimits& mode = view.modes.joint_velocity;
  const auto along = [](double velocity) { return Eigen::Vector3d(velocity, 0.0, 0.0); };
  for (const std::uint8_t j : view.now.action->active) {
    const auto commanded_by = [&](const Setpoint& row) {
      return along(commanded_velocity(view.limits, row, j, view.before.positions));
    };
    const Eigen::Vector3d commanded = commanded_by(view.now);
    const bool goes_on = view.previous.action != nullptr && view.previous.commands(j);
    const TrackingSpan span =
        goes_on ? TrackingSpan::after_row(mode.gain, commanded_by(view.previous), commanded)
                : TrackingSpan::after_hold(mode.gain, along(view.before.velocities[j]), commanded);
    const JointLimits& joint = view.limits.joints[j];
    const Evidence evidence =
        within(joint.name.view(), span.distance(along(view.state.velocities[j])), mode.tracking[j],
               velocity_unit(joint.kind), "tracking_limits");
    if (!evidence.ok()) return evidence;
  }
  return {};
}

// What was measured when the row began, and in its tick, in the row's own unit: m and rad in a
// tick, or in a second.
struct Motions {
  Twist before;
  Twist during;
};

// False if the part is no base of two slides and a yaw.
bool measure_base(const MotionView& view, Motions& measured) {
  if (!base_displacement(view, measured.during) ||
      !measured_base_twist(view.limits, view.part(), view.before, measured.before))
    return false;
  measured.during.linear /= view.period_s();
  measured.during.angular /= view.period_s();
  return true;
}

void measure_tool(const MotionView& view, Motions& measured) {
  measured.before = link_twist(view.model, view.before, link_of(view.limits, view.now),
                               view.part().tool, &view.part());
  measured.during = tool_displacement(view);
  const bool per_tick = view.mode() == static_cast<std::uint8_t>(Mode::cartesian_delta);
  if (per_tick) {
    measured.before.linear *= view.period_s();
    measured.before.angular *= view.period_s();
  } else {
    measured.during.linear /= view.period_s();
    measured.during.angular /= view.period_s();
  }
}

TrackingSpan span_of(const MotionView& view, const Gain& gain, const Twist& before,
                     Eigen::Vector3d Twist::*half) {
  const Twist commanded = halves(view.now);
  if (view.previous.action == nullptr)
    return TrackingSpan::after_hold(gain, before.*half, commanded.*half);
  return TrackingSpan::after_row(gain, halves(view.previous).*half, commanded.*half);
}

Evidence check_halves(const MotionView& view) {
  const CartesianLimits& mode = *norm_block(view.modes, view.mode());
  Motions measured;
  if (view.mode() != static_cast<std::uint8_t>(Mode::body_twist))
    measure_tool(view, measured);
  else if (!measure_base(view, measured))
    return {};
  const auto off = [&](Eigen::Vector3d Twist::*half) {
    return span_of(view, mode.gain, measured.before, half).distance(measured.during.*half);
  };
  const bool per_tick = view.mode() == static_cast<std::uint8_t>(Mode::cartesian_delta);
  return halves_within(off(&Twist::linear), mode.linear_tracking, off(&Twist::angular),
                       mode.angular_tracking, per_tick ? in_a_tick : in_a_second);
}

Evidence check_pose(const MotionView& view) {
  const PoseLimits& mode = view.modes.cartesian_pose;
  const PoseError error = pose_error(view);
  return halves_within(error.distance, mode.linear_tracking, error.angle, mode.angular_tracking,
                       in_a_tick);
}

}  // namespace

Evidence check_tracking(const MotionView& view) {
  switch (static_cast<Mode>(view.mode())) {
    case Mode::joint_position:
    case Mode::dex_hand_joint:
      return check_targets(view);
    case Mode::cartesian_pose:
      return check_pose(view);
    case Mode::joint_velocity:
      return view.consecutive ? check_velocities(view) : Evidence{};
    case Mode::cartesian_delta:
    case Mode::cartesian_twist:
    case Mode::body_twist:
      return view.consecutive ? check_halves(view) : Evidence{};
    default:
      return {};
  }
}

// The four points of a span lie in one plane (through the origin), so what is between them is two
// triangles.
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
