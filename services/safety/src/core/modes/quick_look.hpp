// A first look at a part's rows, quick because it finds no words: whether all of them keep to their
// limits for certain. If not, they are judged with care, row by row, which finds the fault and
// words it; so nothing that the quick look doubts is refused for that.
#pragma once

#include <cstdint>

#include "core/chunk/judgement.hpp"
#include "core/kinematics/robot_model.hpp"

namespace fairlead {

/// What is certain of a part's rows; each includes the one before it.
enum class Certain : std::uint8_t {
  nothing,   // as always of a mode that commands no single joints
  in_order,  // every row keeps to what check_absolute asks, and each but the first to what
             // check_step asks
  starts,    // the first keeps to what check_start asks, too; of joint targets alone
};

/// Rows from `first_row` on.
Certain look_quickly(const PathPlan& plan, const ModeLimits& modes, const MeasuredState& state,
                     const ActionPart& action, std::size_t first_row, std::size_t horizon,
                     const RowBefore& before);

}  // namespace fairlead
