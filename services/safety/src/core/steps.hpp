// G021 and G022: how far one setpoint may be from what came before it.
#pragma once

#include "fairlead_safety/judge.hpp"

namespace fairlead {

/// G022: row `row` against row `row - 1` of the same part.
Evidence check_step(const Limits& limits, const ModeLimits& modes, const ActionPart& action,
                    std::size_t row);

/// G021: the first live row against the measured state and against what acts before it.
Evidence check_start(const Limits& limits, const ModeLimits& modes, const MeasuredState& state,
                     const ActionPart& action, std::size_t row, const RowBefore& before);

}  // namespace fairlead
