#include "core/modes/row_limit_check.hpp"

#include <algorithm>

namespace fairlead {

RowLimitCheck::RowLimitCheck(const PathPlan& plan, const ClaimLimits& claim,
                             const MeasuredState& state, const ActionChunk& chunk,
                             std::size_t first_row, const RowBefore& before)
    : limits_(plan.limits),
      claim_(claim),
      state_(state),
      chunk_(chunk),
      first_row_(first_row),
      before_(before),
      certain_(look(plan)) {}

Certain RowLimitCheck::look(const PathPlan& plan) const {
  Certain all = Certain::starts;
  for (const ActionPart& action : chunk_.parts)
    all = std::min(all, look_quickly(plan, claim_.modes[action.part], state_, action, first_row_,
                                     chunk_.horizon, before_));
  return all;
}

RowView RowLimitCheck::view_of(const ActionPart& action, std::size_t row) const {
  const bool follows = row > first_row_;
  return {limits_, claim_.modes[action.part], state_, row_of(action, row, limits_),
          follows ? row_of(action, row - 1, limits_) : Setpoint{}};
}

Evidence RowLimitCheck::check(std::size_t row) const {
  const auto number = static_cast<std::int64_t>(row);
  if (certain_ == Certain::nothing)
    for (const ActionPart& action : chunk_.parts) {
      const Evidence evidence = check_absolute(view_of(action, row));
      if (!evidence.ok()) return at(evidence, number, limits_.parts[action.part].name);
    }
  for (const ActionPart& action : chunk_.parts) {
    const RowView view = view_of(action, row);
    const Evidence evidence =
        row == first_row_ ? check_start(view, claim_, before_) : check_step(view);
    if (!evidence.ok()) return at(evidence, number, limits_.parts[action.part].name);
  }
  return {};
}

}  // namespace fairlead
