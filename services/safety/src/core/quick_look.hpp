// A first look at a part's rows, quick because it finds no words: whether all of them keep to their
// limits for certain. If not, they are judged with care, row by row, which finds the fault and
// words it; so nothing that the quick look doubts is refused for that.
#pragma once

#include "fairlead_safety/judge.hpp"

namespace fairlead {

/// Every row from `first_row` on keeps to what check_absolute asks, and each but the first to what
/// check_step asks. False where that is not certain, as in every mode that commands no single
/// joints.
bool certainly_in_order(const Limits& limits, const ModeLimits& modes, const MeasuredState& state,
                        const ActionPart& action, std::size_t first_row, std::size_t horizon);

}  // namespace fairlead
