// G020: limits that hold for a row by itself; and G011's rule for joints found outside theirs.
#pragma once

#include "fairlead_safety/judge.hpp"

namespace fairlead {

/// Check row `row` of `action`. `row` > `first_row` continues the row before it.
Evidence check_absolute(const Limits& limits, const ModeLimits& modes, const MeasuredState& state,
                        const ActionPart& action, std::size_t row, std::size_t first_row);

/// G011: whether a measurement lies outside its bounds by more than their tolerance.
bool is_outside(const Bounds& bounds, double measured);

}  // namespace fairlead
