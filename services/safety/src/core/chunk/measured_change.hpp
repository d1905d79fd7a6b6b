// How far a measured joint went from one position to another.
#pragma once

#include <cmath>
#include <numbers>

#include "fairlead_safety/limits.hpp"

namespace fairlead {

/// From one position of a commanded joint to another [rad or m]; a continuous one may be reported
/// in any turn.
inline double measured_change(const JointLimits& joint, double from, double to) {
  const double change = to - from;
  return joint.kind == JointKind::continuous ? std::remainder(change, 2.0 * std::numbers::pi)
                                             : change;
}

/// The same of measured joint `i`, which may be passive.
inline double measured_change(const Limits& limits, std::size_t i, double from, double to) {
  return i < limits.joints.size() ? measured_change(limits.joints[i], from, to) : to - from;
}

}  // namespace fairlead
