#include "path_walk.hpp"

namespace fairlead {

PathWalk::PathWalk(const PathPlan&, const ClaimLimits&, const MeasuredState&, const ActionChunk&,
                   std::size_t, const RowBefore&, Companions) {}

Evidence PathWalk::check_next() { return {}; }

Judgement judge_path(const PathPlan& plan, const ClaimLimits& claim, const MeasuredState& state,
                     const ActionChunk& chunk, std::size_t first_row, std::size_t end_row,
                     const RowBefore& before, Companions companions) {
  Judgement judgement;
  judgement.first_row = first_row;
  PathWalk walk(plan, claim, state, chunk, first_row, before, companions);
  for (std::size_t row = first_row; row < end_row; ++row) {
    judgement.evidence = walk.check_next();
    if (!judgement.evidence.ok()) break;
    ++judgement.row_count;
  }
  if (judgement.row_count == 0) return judgement;
  judgement.outcome = judgement.evidence.ok() ? Outcome::released : Outcome::truncated;
  return judgement;
}

}  // namespace fairlead
