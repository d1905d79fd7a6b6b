// A first look at a part's rows, quick because it finds no words: which of them keep to their
// limits for certain. The other rows are judged with care, which finds the fault and words it; so
// nothing that the quick look leaves out is refused for that.
#pragma once

#include "fairlead_safety/judge.hpp"

namespace fairlead {

/// The rows from `first_row` on, as many as there are before the first doubtful one, keep to what
/// check_absolute asks, and all but the first to what check_step asks. Returns that first doubtful
/// row; `first_row` if none is certain, which is so in every mode that commands no single joints.
std::size_t first_doubtful_row(const Limits& limits, const ModeLimits& modes,
                               const MeasuredState& state, const ActionPart& action,
                               std::size_t first_row, std::size_t horizon);

}  // namespace fairlead
