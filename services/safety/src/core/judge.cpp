#include "fairlead_safety/judge.hpp"

#include "mode_checkers.hpp"
#include "path/path_walk.hpp"

namespace fairlead {
namespace {

RowView view_of(const Limits& limits, const ClaimLimits& claim, const MeasuredState& state,
                const ActionPart& action, std::size_t row, std::size_t first_row) {
  const Setpoint previous = row > first_row ? row_of(action, row - 1, limits) : Setpoint{};
  return {limits, claim.modes[action.part], state, row_of(action, row, limits), previous};
}

// What is wrong with one row, over all parts of the chunk: a row runs for all of them or for none.
Evidence check_row(const Limits& limits, const ClaimLimits& claim, const MeasuredState& state,
                   const ActionChunk& chunk, std::size_t row, std::size_t first_row,
                   const RowBefore& before) {
  for (const ActionPart& action : chunk.parts) {
    const Evidence evidence = check_absolute(view_of(limits, claim, state, action, row, first_row));
    if (!evidence.ok())
      return at(evidence, static_cast<std::int64_t>(row), limits.parts[action.part].name);
  }
  for (const ActionPart& action : chunk.parts) {
    const RowView view = view_of(limits, claim, state, action, row, first_row);
    const Evidence evidence = row == first_row ? check_start(view, before) : check_step(view);
    if (!evidence.ok())
      return at(evidence, static_cast<std::int64_t>(row), limits.parts[action.part].name);
  }
  return {};
}

}  // namespace

Evidence check_running(const Limits& limits, const ClaimLimits& claim, const MeasuredState& state,
                       const ActionChunk& chunk, std::size_t row) {
  for (const ActionPart& action : chunk.parts) {
    const Evidence evidence = check_acting(view_of(limits, claim, state, action, row, 0));
    if (!evidence.ok())
      return at(evidence, static_cast<std::int64_t>(row), limits.parts[action.part].name);
  }
  return {};
}

Judgement judge_rows(const PathPlan& plan, const ClaimLimits& claim, const MeasuredState& state,
                     const ActionChunk& chunk, std::size_t first_row, const RowBefore& before,
                     Companions companions) {
  Judgement judgement;
  judgement.first_row = first_row;
  PathWalk walk(plan, claim, state, chunk, first_row, before, companions);
  for (std::size_t row = first_row; row < chunk.horizon; ++row) {
    judgement.evidence = check_row(plan.limits, claim, state, chunk, row, first_row, before);
    if (judgement.evidence.ok()) judgement.evidence = walk.check_next();
    if (!judgement.evidence.ok()) break;
    ++judgement.row_count;
  }
  if (judgement.row_count == 0) return judgement;  // refused, by its first row
  judgement.outcome = judgement.evidence.ok() ? Outcome::released : Outcome::truncated;
  return judgement;
}

}  // namespace fairlead
