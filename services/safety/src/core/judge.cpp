#include "fairlead_safety/judge.hpp"

#include "limit_walk.hpp"
#include "path/path_walk.hpp"

namespace fairlead {

Evidence check_running(const Limits& limits, const ClaimLimits& claim, const MeasuredState& state,
                       const ActionChunk& chunk, std::size_t row) {
  for (const ActionPart& action : chunk.parts) {
    const Evidence evidence = check_acting(
        {limits, claim.modes[action.part], state, row_of(action, row, limits), Setpoint{}});
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
  const LimitWalk by_limits(plan.limits, claim, state, chunk, first_row, before);
  PathWalk by_path(plan, claim, state, chunk, first_row, before, companions);
  for (std::size_t row = first_row; row < chunk.horizon; ++row) {
    if (by_limits.needs_check(row)) judgement.evidence = by_limits.check(row);
    if (judgement.evidence.ok()) judgement.evidence = by_path.check_next();
    if (!judgement.evidence.ok()) break;
    ++judgement.row_count;
  }
  if (judgement.row_count == 0) return judgement;  // refused, by its first row
  judgement.outcome = judgement.evidence.ok() ? Outcome::released : Outcome::truncated;
  return judgement;
}

}  // namespace fairlead
