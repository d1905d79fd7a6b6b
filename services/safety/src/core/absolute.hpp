// G020: limits that hold for a row by itself; and G011's rule for joints found outside theirs.
#pragma once

#include "fairlead_safety/judge.hpp"

namespace fairlead {

/// Check row `row` of `action`. `row` > `first_row` continues the row before it.
Evidence check_absolute(const Limits& limits, const ModeLimits& modes, const MeasuredState& state,
                        const ActionPart& action, std::size_t row, std::size_t first_row);

/// G011: a passive joint outside its bounds; no command could bring it back.
Evidence check_passive(const Limits& limits, const MeasuredState& state);

}  // namespace fairlead
