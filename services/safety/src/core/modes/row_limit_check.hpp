// The rows of a chunk against their limits, one after the other: G011, G020, G021, G022.
#pragma once

#include "core/kinematics/robot_model.hpp"
#include "core/modes/mode_table.hpp"

namespace fairlead {

class RowLimitCheck {
 public:
  /// Everything must outlive it.
  RowLimitCheck(const PathPlan& plan, const ClaimLimits& claim, const MeasuredState& state,
                const ActionChunk& chunk, std::size_t first_row, const RowBefore& before);

  /// What is wrong with the row, over all parts of the chunk: it runs for all of them or for none.
  [[nodiscard]] Evidence check(std::size_t row) const;

 private:
  [[nodiscard]] RowView view_of(const ActionPart& action, std::size_t row) const;

  const Limits& limits_;
  const ClaimLimits& claim_;
  const MeasuredState& state_;
  const ActionChunk& chunk_;
  const std::size_t first_row_;
  const RowBefore& before_;
  const bool in_order_;  // all parts' rows, by `rows_in_order`
};

/// Whether check_absolute finds no fault with any row of a part from `first_row` to `end_row`, nor
/// check_step with any but the first: the same comparisons, joint by joint and without words. False
/// says nothing; so it is of modes that command no single joints.
bool rows_in_order(const Limits& limits, const ModeLimits& modes, const MeasuredState& state,
                   const ActionPart& action, std::size_t first_row, std::size_t end_row);

}  // namespace fairlead
