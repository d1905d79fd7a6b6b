// The rows of a chunk against their limits, one after the other: G011, G020, G021, G022.
#pragma once

#include "core/kinematics/robot_model.hpp"
#include "core/modes/mode_table.hpp"
#include "core/modes/quick_look.hpp"

namespace fairlead {

class RowLimitCheck {
 public:
  /// Everything must outlive the walk.
  RowLimitCheck(const PathPlan& plan, const ClaimLimits& claim, const MeasuredState& state,
                const ActionChunk& chunk, std::size_t first_row, const RowBefore& before);

  /// False for a row that needs no more than the quick look at all of them.
  [[nodiscard]] bool needs_check(std::size_t row) const {
    return row == first_row_ ? certain_ != Certain::starts : certain_ == Certain::nothing;
  }

  /// What is wrong with the row, over all parts of the chunk: it runs for all of them or for none.
  [[nodiscard]] Evidence check(std::size_t row) const;

 private:
  [[nodiscard]] Certain look(const PathPlan& plan) const;
  [[nodiscard]] RowView view_of(const ActionPart& action, std::size_t row) const;

  const Limits& limits_;
  const ClaimLimits& claim_;
  const MeasuredState& state_;
  const ActionChunk& chunk_;
  const std::size_t first_row_;
  const RowBefore& before_;
  const Certain certain_;  // of all parts together
};

}  // namespace fairlead
