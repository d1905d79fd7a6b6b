// A claim's own limits: each may only be tighter than the robot's.

#include <algorithm>

#include "core/gate/admission.hpp"
#include "core/wire/phrase.hpp"
#include "fairlead_safety/limits.hpp"

namespace fairlead {
namespace {

Text refuse(const LimitOverride& wanted, const Text& room) {
  return phrase("limits: ", wanted.part, " ", mode_name(wanted.mode), " ", wanted.name,
                ": expected ", room, ", got ", wanted.value);
}

// An upper limit: positive and not above the present one. NaN fails.
Text lower_it(const LimitOverride& wanted, double& limit) {
  if (!(wanted.value > 0.0 && wanted.value <= limit))
    return refuse(wanted, phrase("above 0 and at most ", limit));
  limit = wanted.value;
  return {};
}

Text no_such_limit(const LimitOverride& wanted) {
  return phrase("limits: ", wanted.part, " ", mode_name(wanted.mode), " has no limit ",
                wanted.name);
}

Text tighten_norms(const LimitOverride& wanted, CartesianLimits& mode) {
  if (wanted.name == "linear_limit") return lower_it(wanted, mode.linear_limit);
  if (wanted.name == "angular_limit") return lower_it(wanted, mode.angular_limit);
  if (wanted.name == "linear_step_limit") return lower_it(wanted, mode.linear_step_limit);
  if (wanted.name == "angular_step_limit") return lower_it(wanted, mode.angular_step_limit);
  return no_such_limit(wanted);
}

// The lower end of a range only rises, and stays below the upper one. NaN fails.
Text raise_lower(const LimitOverride& wanted, double& lower, double upper) {
  if (!(wanted.value >= lower && wanted.value < upper))
    return refuse(wanted, phrase("at least ", lower, " and below upper, ", upper));
  lower = wanted.value;
  return {};
}

Text lower_upper(const LimitOverride& wanted, double lower, double& upper) {
  if (!(wanted.value <= upper && wanted.value > lower))
    return refuse(wanted, phrase("above lower, ", lower, ", and at most ", upper));
  upper = wanted.value;
  return {};
}

Text tighten_scalar(const LimitOverride& wanted, ScalarLimits& mode) {
  if (wanted.name == "step_limit") return lower_it(wanted, mode.step_limit);
  if (wanted.name == "lower") return raise_lower(wanted, mode.lower, mode.upper);
  if (wanted.name == "upper") return lower_upper(wanted, mode.lower, mode.upper);
  return no_such_limit(wanted);
}

// The joints' own limits are the robot's; a claim adds one of its own, not above any of them.
Text tighten_velocity(const Limits& limits, const PartLimits& part, const LimitOverride& wanted,
                      JointModeLimits& mode) {
  double limit = mode.claimed_limit;
  for (const std::size_t joint : part.joints)
    limit = std::min(limits.joints[joint].velocity_limit,
                     limit);  // the joint's where it is NaN: none yet
  const Text fault = lower_it(wanted, limit);
  if (fault.empty()) mode.claimed_limit = limit;
  return fault;
}

Text tighten_joints(const Limits& limits, const PartLimits& part, const LimitOverride& wanted,
                    JointModeLimits& mode) {
  if (wanted.name == "velocity_limit" &&
      wanted.mode == static_cast<std::uint8_t>(Mode::joint_velocity))
    return tighten_velocity(limits, part, wanted, mode);
  if (!(wanted.name == "step_limit")) return no_such_limit(wanted);
  for (const std::size_t joint : part.joints) {
    const Text fault = lower_it(wanted, mode.step_limit[joint]);
    if (!fault.empty()) return fault;
  }
  return {};
}

Text tighten_pose(const LimitOverride& wanted, PoseLimits& mode) {
  if (wanted.name == "linear_step_limit") return lower_it(wanted, mode.linear_step_limit);
  if (wanted.name == "angular_step_limit") return lower_it(wanted, mode.angular_step_limit);
  constexpr std::array<std::string_view, 3> lower{"lower_x", "lower_y", "lower_z"};
  constexpr std::array<std::string_view, 3> upper{"upper_x", "upper_y", "upper_z"};
  for (std::size_t i = 0; i < lower.size(); ++i) {
    if (wanted.name == lower[i]) return raise_lower(wanted, mode.lower[i], mode.upper[i]);
    if (wanted.name == upper[i]) return lower_upper(wanted, mode.lower[i], mode.upper[i]);
  }
  return no_such_limit(wanted);
}

}  // namespace

Text tighten(const Limits& limits, std::size_t part, const LimitOverride& wanted,
             ModeLimits& modes) {
  if (!modes.supports(wanted.mode))
    return phrase("limits: ", wanted.part, " has no mode ", mode_name(wanted.mode), " (",
                  wanted.mode, ")");
  if (JointModeLimits* joints = joint_block(modes, wanted.mode))
    return tighten_joints(limits, limits.parts[part], wanted, *joints);
  if (CartesianLimits* norms = norm_block(modes, wanted.mode)) return tighten_norms(wanted, *norms);
  if (ScalarLimits* scalar = scalar_block(modes, wanted.mode))
    return tighten_scalar(wanted, *scalar);
  if (wanted.mode == static_cast<std::uint8_t>(Mode::cartesian_pose))
    return tighten_pose(wanted, modes.cartesian_pose);
  return no_such_limit(wanted);  // gripper_binary has none
}

}  // namespace fairlead
