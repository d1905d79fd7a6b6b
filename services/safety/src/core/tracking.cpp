#include "tracking.hpp"

#include "fairlead_safety/mode_blocks.hpp"
#include "told_motion.hpp"
#include "tracking_span.hpp"

namespace fairlead {
namespace {

Evidence within(std::string_view axis, double distance, double limit, const Text& source) {
  if (distance <= limit) return {};
  return above(code::tracking, axis, distance, limit, source.view());
}

// A servo lags behind its target: the limit is declared to include it.
Evidence check_targets(const MotionView& view) {
  const JointModeLimits& mode = *joint_block(view.modes, view.mode());
  for (const std::uint8_t j : view.now.action->active) {
    const JointLimits& joint = view.limits.joints[j];
    const double error = std::abs(turned_by(joint, view.now[j], view.state.positions[j]));
    const Evidence evidence = within(joint.name.view(), error, mode.tracking[j], mode.source);
    if (!evidence.ok()) return evidence;
  }
  return {};
}

// A joint that the row before left alone held in it.
Evidence check_velocities(const MotionView& view) {
  const JointModeLimits& mode = view.modes.joint_velocity;
  const auto along = [](double velocity) { return Eigen::Vector3d(velocity, 0.0, 0.0); };
  for (const std::uint8_t j : view.now.action->active) {
    const auto told_by = [&](const Setpoint& row) {
      return along(told_velocity(view.limits, row, j, view.before.positions));
    };
    const Eigen::Vector3d told = told_by(view.now);
    const bool goes_on = view.previous.action != nullptr && view.previous.commands(j);
    const TrackingSpan span =
        goes_on ? TrackingSpan::after_row(mode.gain, told_by(view.previous), told)
                : TrackingSpan::after_hold(mode.gain, along(view.before.velocities[j]), told);
    const Evidence evidence =
        within(view.limits.joints[j].name.view(), span.distance(along(view.state.velocities[j])),
               mode.tracking[j], mode.source);
    if (!evidence.ok()) return evidence;
  }
  return {};
}

// The measured motion in the row's own unit: m and rad in a tick, or in a second.
bool measured_motion(const MotionView& view, Twist& motion) {
  if (view.mode() == static_cast<std::uint8_t>(Mode::body_twist)) {
    if (!base_displacement(view, motion)) return false;
  } else {
    motion = tool_displacement(view);
  }
  if (view.mode() == static_cast<std::uint8_t>(Mode::cartesian_delta)) return true;
  motion.linear /= view.period_s();
  motion.angular /= view.period_s();
  return true;
}

// What the part was measured to do when the row began, in the same unit.
Twist motion_before(const MotionView& view) {
  Twist twist;
  if (view.mode() == static_cast<std::uint8_t>(Mode::body_twist)) {
    (void)measured_base_twist(view.limits, view.part(), view.before, twist);
    return twist;
  }
  const Kinematics& tree = view.limits.kinematics;
  const std::size_t frame = tree.find(view.now.action->frame_id);
  twist = link_twist(tree, view.before, frame, view.part().tool, &view.part());
  if (view.mode() == static_cast<std::uint8_t>(Mode::cartesian_delta)) {
    twist.linear *= view.period_s();
    twist.angular *= view.period_s();
  }
  return twist;
}

TrackingSpan span_of(const MotionView& view, const Gain& gain, Eigen::Vector3d Twist::*half) {
  const Twist told = halves(view.now);
  if (view.previous.action == nullptr)
    return TrackingSpan::after_hold(gain, motion_before(view).*half, told.*half);
  return TrackingSpan::after_row(gain, halves(view.previous).*half, told.*half);
}

Evidence check_halves(const MotionView& view) {
  const CartesianLimits& mode = *norm_block(view.modes, view.mode());
  Twist motion;
  if (!measured_motion(view, motion)) return {};
  const Evidence linear =
      within("linear", span_of(view, mode.gain, &Twist::linear).distance(motion.linear),
             mode.linear_tracking, mode.source);
  if (!linear.ok()) return linear;
  return within("angular", span_of(view, mode.gain, &Twist::angular).distance(motion.angular),
                mode.angular_tracking, mode.source);
}

Evidence check_pose(const MotionView& view) {
  const PoseLimits& mode = view.modes.cartesian_pose;
  const PoseError error = pose_error(view);
  const Evidence linear = within("linear", error.distance, mode.linear_tracking, mode.source);
  if (!linear.ok()) return linear;
  return within("angular", error.angle, mode.angular_tracking, mode.source);
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

}  // namespace fairlead
