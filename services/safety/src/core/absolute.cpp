#include "absolute.hpp"

#include <algorithm>
#include <cmath>

#include "evidence.hpp"

namespace fairlead {
namespace {

// How far `position` lies outside the bounds, signed by the side; 0 inside.
double excess(const Bounds& bounds, double position) {
  if (position > bounds.upper) return position - bounds.upper;
  if (position < bounds.lower) return position - bounds.lower;
  return 0.0;
}

}  // namespace

bool is_outside(const Bounds& bounds, double measured) {
  return !(std::abs(excess(bounds, measured)) <= bounds.tolerance);
}

namespace {

// One number against a range that includes its ends.
Evidence in_range(std::string_view axis, double value, double lower, double upper,
                  const Text& source) {
  if (!(value <= upper)) return above(code::absolute, axis, value, upper, source.view());
  if (!(value >= lower)) return below(code::absolute, axis, value, lower, source.view());
  return {};
}

// G011: the measurement is outside; the target must lie strictly nearer than what it follows.
Evidence reduces(const JointLimits& joint, double target, double previous) {
  const double now = std::abs(excess(joint.bounds, target));
  const double then = std::abs(excess(joint.bounds, previous));
  if (now < then || now == 0.0) return {};
  return above(code::state, joint.name.view(), now, then, "outside its bounds: only towards them");
}

// joint_position: every commanded target lies within its joint's bounds.
Evidence check_positions(const Limits& limits, const MeasuredState& state, const ActionPart& action,
                         std::size_t row, std::size_t first_row) {
  const std::size_t width = limits.joints.size();
  for (const std::uint8_t j : action.active) {
    const JointLimits& joint = limits.joints[j];
    if (!joint.bounded) continue;  // continuous: no bound by declaration
    const double target = action.values[row * width + j];
    const double previous =
        row > first_row ? action.values[(row - 1) * width + j] : state.positions[j];
    const Evidence evidence = is_outside(joint.bounds, state.positions[j])
                                  ? reduces(joint, target, previous)
                                  : in_range(joint.name.view(), target, joint.bounds.lower,
                                             joint.bounds.upper, joint.source);
    if (!evidence.ok()) return evidence;
  }
  return {};
}

// joint_velocity: within the joint's velocity limit, and the claim's where it has a tighter one;
// towards the bounds where the joint is outside them.
Evidence check_velocities(const Limits& limits, const JointModeLimits& mode,
                          const MeasuredState& state, const ActionPart& action, std::size_t row) {
  const std::size_t width = limits.joints.size();
  for (const std::uint8_t j : action.active) {
    const JointLimits& joint = limits.joints[j];
    const double value = action.values[row * width + j];
    const double limit = mode.claimed_velocity > 0.0
                             ? std::min(mode.claimed_velocity, joint.velocity_limit)
                             : joint.velocity_limit;
    const Evidence evidence = in_range(joint.name.view(), value, -limit, limit, joint.source);
    if (!evidence.ok()) return evidence;
    if (!joint.bounded || !is_outside(joint.bounds, state.positions[j])) continue;
    if (value * excess(joint.bounds, state.positions[j]) < 0.0) continue;
    return above(code::state, joint.name.view(), value, 0.0,
                 "outside its bounds: only towards them");
  }
  return {};
}

double norm3(const ActionPart& action, std::size_t first) {
  const double x = action.values[first];
  const double y = action.values[first + 1];
  const double z = action.values[first + 2];
  return std::sqrt(x * x + y * y + z * z);  // at most 1e6 each: no overflow
}

// cartesian_delta, body_twist: norms of the linear and the angular half, not single axes.
Evidence check_norms(const CartesianLimits& mode, const ActionPart& action, std::size_t row) {
  const double linear = norm3(action, row * 6);
  if (!(linear <= mode.linear_limit))
    return above(code::absolute, "linear", linear, mode.linear_limit, mode.source.view());
  const double angular = norm3(action, row * 6 + 3);
  if (!(angular <= mode.angular_limit))
    return above(code::absolute, "angular", angular, mode.angular_limit, mode.source.view());
  return {};
}

bool commands_joint(const ActionPart& action, std::size_t joint) {
  return is_joint_mode(action.mode) && action.active.contains(static_cast<std::uint8_t>(joint));
}

// G011: a joint of the part is outside its bounds and this row cannot be seen to bring it back.
Evidence check_unmoved_joints(const Limits& limits, const MeasuredState& state,
                              const ActionPart& action) {
  // A gripper target is the joint's own position and has passed the range check.
  if (action.mode == static_cast<std::uint8_t>(Mode::gripper_position)) return {};
  for (const std::size_t j : limits.parts[action.part].joints) {
    const JointLimits& joint = limits.joints[j];
    if (!joint.bounded || !is_outside(joint.bounds, state.positions[j]) ||
        commands_joint(action, j))
      continue;
    const double bound =
        excess(joint.bounds, state.positions[j]) > 0.0 ? joint.bounds.upper : joint.bounds.lower;
    return above(code::state, joint.name.view(), state.positions[j], bound,
                 "measured outside bounds + tolerance: only rows that reduce it");
  }
  return {};
}

}  // namespace

Evidence check_absolute(const Limits& limits, const ModeLimits& modes, const MeasuredState& state,
                        const ActionPart& action, std::size_t row, std::size_t first_row) {
  const Evidence evidence = check_unmoved_joints(limits, state, action);
  if (!evidence.ok()) return evidence;
  switch (static_cast<Mode>(action.mode)) {
    case Mode::joint_position:
      return check_positions(limits, state, action, row, first_row);
    case Mode::joint_velocity:
      return check_velocities(limits, modes.joint_velocity, state, action, row);
    case Mode::cartesian_delta:
      return check_norms(modes.cartesian_delta, action, row);
    case Mode::body_twist:
      return check_norms(modes.body_twist, action, row);
    case Mode::gripper_position:
      return in_range("opening", action.values[row], modes.gripper_position.lower,
                      modes.gripper_position.upper, modes.gripper_position.source);
    case Mode::composite_mode:
      return in_range("composite", action.values[row], modes.composite_mode.lower,
                      modes.composite_mode.upper, modes.composite_mode.source);
    default:
      return broken_rule(code::addressing, mode_name(action.mode), "no checker for this mode",
                         action.mode);
  }
}

}  // namespace fairlead
