#include "core/chunk/judgement.hpp"

#include <optional>

#include "core/modes/row_limit_check.hpp"
#include "core/trajectory/trajectory_check.hpp"

namespace fairlead {
namespace {

// Rows in order, up to the first that `check` finds fault with.
template <class Check>
Judgement judge_each(std::size_t first_row, std::size_t end_row, const PathWalk& by_path,
                     const Check& check) {
  Judgement judgement;
  judgement.first_row = first_row;
  for (std::size_t row = first_row; row < end_row; ++row) {
    judgement.evidence = check(row);
    if (!judgement.evidence.ok()) break;
    ++judgement.row_count;
  }
  judgement.looks = by_path.looks();
  if (judgement.row_count == 0) return judgement;  // refused, by its first row
  judgement.outcome = judgement.evidence.ok() ? Outcome::released : Outcome::truncated;
  return judgement;
}

}  // namespace

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

struct PathRoom::Place {
  std::optional<PathWalk> walk;
};

PathRoom::PathRoom() : place_(std::make_unique<Place>()) {}
PathRoom::~PathRoom() = default;

PathWalk& PathRoom::begin(const PathPlan& plan, const ClaimLimits& claim,
                          const MeasuredState& state, const ActionChunk& chunk,
                          std::size_t first_row, const RowBefore& before, Companions companions) {
  return place_->walk.emplace(plan, claim, state, chunk, first_row, before, companions);
}

Judgement judge_rows(PathRoom& room, const PathPlan& plan, const ClaimLimits& claim,
                     const MeasuredState& state, const ActionChunk& chunk, std::size_t first_row,
                     const RowBefore& before, Companions companions) {
  const LimitWalk by_limits(plan, claim, state, chunk, first_row, before);
  PathWalk& by_path = room.begin(plan, claim, state, chunk, first_row, before, companions);
  return judge_each(first_row, chunk.horizon, by_path, [&](std::size_t row) {
    const Evidence evidence = by_limits.needs_check(row) ? by_limits.check(row) : Evidence{};
    return evidence.ok() ? by_path.check_next() : evidence;
  });
}

Judgement judge_path(PathRoom& room, const PathPlan& plan, const ClaimLimits& claim,
                     const MeasuredState& state, const ActionChunk& chunk, std::size_t first_row,
                     std::size_t end_row, const RowBefore& before, Companions companions) {
  PathWalk& by_path = room.begin(plan, claim, state, chunk, first_row, before, companions);
  return judge_each(first_row, end_row, by_path, [&](std::size_t) { return by_path.check_next(); });
}

}  // namespace fairlead
