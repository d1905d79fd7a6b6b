// A claim's own limits: each may only be tighter than the robot's.
#pragma once

#include "fairlead_safety/limits.hpp"
#include "fairlead_safety/messages.hpp"

namespace fairlead {

/// Apply one override to `modes`; the reason it cannot be applied, "" if it was.
/// A joint mode's `step_limit` is one number for all joints of the part.
Text tighten(const Limits& limits, std::size_t part, const LimitOverride& wanted,
             ModeLimits& modes);

}  // namespace fairlead
