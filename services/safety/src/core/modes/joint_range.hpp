// Where the number that commands a joint may lie, by mode.
#pragma once

#include <algorithm>
#include <limits>

#include "fairlead_safety/limits.hpp"

namespace fairlead {

struct JointRange {
  double lower = unset;
  double upper = unset;
};

/// G020: inside the bounds as a target, if it has any; else within the joint's own limit in both
/// directions, and within the claim's where that is tighter.
inline JointRange joint_range(const JointLimits& joint, const JointModeLimits& mode,
                              std::uint8_t number) {
  constexpr double endless = std::numeric_limits<double>::infinity();
  if (number == static_cast<std::uint8_t>(Mode::joint_velocity)) {
    // The joint's own where the claim has none, NaN.
    const double limit = std::min(joint.velocity_limit, mode.claimed_limit);
    return {-limit, limit};
  }
  if (!joint.bounded) return {-endless, endless};  // continuous: no bound by declaration
  return {joint.bounds.lower, joint.bounds.upper};
}

}  // namespace fairlead
