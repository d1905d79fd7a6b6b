#include "tightening.hpp"

#include "phrase.hpp"

namespace fairlead {
namespace {

Text refuse(const LimitOverride& wanted, std::string_view rule, double limit) {
  return phrase("limits: ", wanted.part, " ", mode_name(wanted.mode), " ", wanted.name,
                ": expected ", rule, " ", limit, ", got ", wanted.value);
}

// An upper limit: positive and not above the present one. NaN fails.
Text lower_it(const LimitOverride& wanted, double& limit) {
  if (!(wanted.value > 0.0 && wanted.value <= limit))
    return refuse(wanted, "above 0 and at most", limit);
  limit = wanted.value;
  return {};
}

Text no_such_limit(const LimitOverride& wanted) {
  return phrase("limits: ", wanted.part, " ", mode_name(wanted.mode), " has no limit ",
                wanted.name);
}

Text tighten_cartesian(const LimitOverride& wanted, CartesianLimits& mode) {
  if (wanted.name == "linear_limit") return lower_it(wanted, mode.linear_limit);
  if (wanted.name == "angular_limit") return lower_it(wanted, mode.angular_limit);
  if (wanted.name == "linear_step_limit") return lower_it(wanted, mode.linear_step_limit);
  if (wanted.name == "angular_step_limit") return lower_it(wanted, mode.angular_step_limit);
  return no_such_limit(wanted);
}

Text tighten_scalar(const LimitOverride& wanted, ScalarLimits& mode) {
  if (wanted.name == "step_limit") return lower_it(wanted, mode.step_limit);
  if (wanted.name == "lower") {
    if (!(wanted.value >= mode.lower && wanted.value < mode.upper))
      return refuse(wanted, "at least", mode.lower);
    mode.lower = wanted.value;
    return {};
  }
  if (wanted.name == "upper") {
    if (!(wanted.value <= mode.upper && wanted.value > mode.lower))
      return refuse(wanted, "at most", mode.upper);
    mode.upper = wanted.value;
    return {};
  }
  return no_such_limit(wanted);
}

// The joints' own limits are the robot's; a claim adds one of its own, not above any of them.
Text tighten_velocity(const Limits& limits, const PartLimits& part, const LimitOverride& wanted,
                      JointModeLimits& mode) {
  double limit = mode.claimed_velocity;
  for (const std::size_t joint : part.joints) {
    const double own = limits.joints[joint].velocity_limit;
    if (!(limit <= own)) limit = own;
  }
  const Text fault = lower_it(wanted, limit);
  if (fault.empty()) mode.claimed_velocity = limit;
  return fault;
}

Text tighten_joints(const PartLimits& part, const LimitOverride& wanted, JointModeLimits& mode) {
  if (!(wanted.name == "step_limit")) return no_such_limit(wanted);
  for (const std::size_t joint : part.joints) {
    const Text fault = lower_it(wanted, mode.step_limit[joint]);
    if (!fault.empty()) return fault;
  }
  return {};
}

}  // namespace

Text tighten(const Limits& limits, std::size_t part, const LimitOverride& wanted,
             ModeLimits& modes) {
  if (!modes.supports(wanted.mode))
    return phrase("limits: ", wanted.part, " has no mode ", mode_name(wanted.mode), " (",
                  wanted.mode, ")");
  switch (static_cast<Mode>(wanted.mode)) {
    case Mode::joint_position:
      return tighten_joints(limits.parts[part], wanted, modes.joint_position);
    case Mode::joint_velocity:
      if (wanted.name == "velocity_limit")
        return tighten_velocity(limits, limits.parts[part], wanted, modes.joint_velocity);
      return tighten_joints(limits.parts[part], wanted, modes.joint_velocity);
    case Mode::cartesian_delta:
      return tighten_cartesian(wanted, modes.cartesian_delta);
    case Mode::body_twist:
      return tighten_cartesian(wanted, modes.body_twist);
    case Mode::gripper_position:
      return tighten_scalar(wanted, modes.gripper_position);
    case Mode::composite_mode:
      return tighten_scalar(wanted, modes.composite_mode);
    default:
      return no_such_limit(wanted);
  }
}

}  // namespace fairlead
