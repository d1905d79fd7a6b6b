#include "fairlead_safety/judge.hpp"

#include "mode_checkers.hpp"

namespace fairlead {
namespace {

// What is wrong with one row, over all parts of the chunk: a row runs for all of them or for none.
Evidence check_row(const Limits& limits, const ClaimLimits& claim, const MeasuredState& state,
                   const ActionChunk& chunk, std::size_t row, std::size_t first_row,
                   const RowBefore& before) {
  const bool is_first = row == first_row;
  for (const bool steps : {false, true}) {
    for (const ActionPart& action : chunk.parts) {
      const Setpoint previous = row_of(action, is_first ? row : row - 1, limits);
      const RowView view{limits, claim.modes[action.part], state, row_of(action, row, limits),
                         is_first ? nullptr : &previous};
      const Evidence evidence = !steps     ? check_absolute(view)
                                : is_first ? check_start(view, before)
                                           : check_step(view);
      if (!evidence.ok())
        return at(evidence, static_cast<std::int64_t>(row), limits.parts[action.part].name);
    }
  }
  return {};
}

}  // namespace

Judgement judge_rows(const Limits& limits, const ClaimLimits& claim, const MeasuredState& state,
                     const ActionChunk& chunk, std::size_t first_row, const RowBefore& before) {
  Judgement judgement;
  judgement.first_row = first_row;
  for (std::size_t row = first_row; row < chunk.horizon; ++row) {
    judgement.evidence = check_row(limits, claim, state, chunk, row, first_row, before);
    if (!judgement.evidence.ok()) break;
    ++judgement.row_count;
  }
  if (judgement.row_count == 0) return judgement;  // refused, by its first row
  judgement.outcome = judgement.evidence.ok() ? Outcome::released : Outcome::truncated;
  return judgement;
}

}  // namespace fairlead
