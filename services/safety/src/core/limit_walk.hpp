// The rows of a chunk against their limits, one after the other: G011, G020, G021, G022.
#pragma once

#include "mode_checkers.hpp"

namespace fairlead {

class LimitWalk {
 public:
  /// Everything must outlive the walk.
  LimitWalk(const Limits& limits, const ClaimLimits& claim, const MeasuredState& state,
            const ActionChunk& chunk, std::size_t first_row, const RowBefore& before);

  /// False for a row that needs no more than the quick look at all of them.
  [[nodiscard]] bool needs_check(std::size_t row) const { return row == first_row_ || !in_order_; }

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
  bool in_order_ = true;  // a quick look has found all rows in order, but for the first one's start
};

}  // namespace fairlead
