// Each new state against the rows that acted before it (G040, G041, G042), and what is left of the
// releases judged again from it.

#include <algorithm>

#include "core/gate/gate_core.hpp"
#include "core/monitor/tracking.hpp"

namespace fairlead {
namespace {

// What a row of a claim tells one part; of no action if it says nothing to it.
Setpoint told_to(const RowBefore& row, std::size_t part, const Limits& limits) {
  if (row.chunk == nullptr) return {};
  for (const ActionPart& action : row.chunk->parts)
    if (action.part == part) return row_of(action, row.row, limits);
  return {};
}

}  // namespace

// Not judged: a part that held, and a row of a claim that has ended or whose numbers are gone.
Evidence Gate::Core::watch_part(std::size_t part, const MeasuredState& before) {
  const LiveClaim* claim = claims_.holder_of(part);
  if (claim == nullptr) {
    grasp_watch_.forget(part);
    return {};
  }
  const ReleasePlan& plan = claim->plan;
  const Acted& act = hal_.state().acted[part];
  const Setpoint now = told_to(plan.row_of(act), part, limits_);
  Evidence evidence = grasp_watch_.note(limits_, hal_.state(), part, now);
  if (!evidence.ok() || now.action == nullptr) return evidence;
  Setpoint previous = told_to(plan.row_of(plan.act_before(act)), part, limits_);
  // Another mode or frame was left at standstill.
  if (previous.action != nullptr && (previous.action->mode != now.action->mode ||
                                     !(previous.action->frame_id == now.action->frame_id)))
    previous = Setpoint{};
  const MotionView view{limits_,
                        claim->limits.modes[part],
                        before,
                        hal_.state(),
                        jump_memory_ && before.tick + 1 == hal_.tick(),
                        now,
                        previous};
  evidence = check_tracking(view);
  return evidence.ok() && jump_memory_ ? stuck_watch_.after_row(view) : evidence;
}

// What the newest state says of the rows that acted before it. Asked before the plans move on.
Evidence Gate::Core::watch_motion(const MeasuredState& before) {
  stuck_watch_.note_state(limits_, hal_.state());
  Evidence evidence = check_contact(limits_, hal_.state());
  for (std::size_t part = 0; part != limits_.parts.size() && evidence.ok(); ++part) {
    evidence = watch_part(part, before);
    if (!evidence.ok()) evidence = of(evidence, limits_.parts[part].name);
  }
  return evidence;
}

// The claim's plan moves on to the newest state.
void Gate::Core::begin_tick_of(LiveClaim& claim) {
  const Acted acted = acted_of(claim);
  ReleasePlan& plan = claim.plan;
  claim.hal_follows = claim.hal_follows || plan.row_of(acted).chunk != nullptr;
  plan.begin_tick(hal_.tick(), acted);
  const Released* release = plan.current();
  // A hold, and a row of the newest release, end whatever the HAL had before.
  if (acted.hold != 0 || (release != nullptr && acted.verdict_id == release->verdict_id))
    claim.until_tick = UINT64_MAX;
  if (release == nullptr) {
    // Rows run on that a later release, which the HAL never took, had replaced.
    if (plan.expected().hold == 0) revoke_from(claim, first_open_tick());
  }
}

// What the plans still hold is judged from the newest state, once all of them have moved on to it:
// each beside what the others then hold. Where one is cut, the others are judged once more, beside
// what it has left; where that goes on, a whole rest is dropped at a time, so that it ends.
void Gate::Core::judge_live() {
  static_assert(max_claims <= 32);
  constexpr int rounds_that_cut = 2;
  std::uint32_t due = (1U << max_claims) - 1U;
  for (int round = 0; due != 0; ++round) {
    std::uint32_t bit = 1;
    for (LiveClaim& claim : claims_.places()) {
      const bool asked = (due & bit) != 0 && claim.plan.current() != nullptr;
      due &= ~bit;
      if (asked && is_cut(claim, round >= rounds_that_cut)) due |= ((1U << max_claims) - 1U) & ~bit;
      bit <<= 1U;
    }
  }
}

// Whether the claim has fewer rows left than it had.
bool Gate::Core::is_cut(LiveClaim& claim, bool drops) {
  const std::uint64_t end_tick = claim.plan.current()->end_tick();
  // The HAL did something else than expected: all of what is left goes out again.
  if (!claim.plan.on_track())
    judge_again(claim);
  else
    judge_rest(claim, drops);
  const Released* left = claim.plan.current();
  return left == nullptr || left->end_tick() < end_tick;
}

// G024, G030 to G034: what is left may not lead where it may not, as the newest state tells. The
// row that acts already (realtime) is past recall; those after it are not.
void Gate::Core::judge_rest(LiveClaim& claim, bool drops) {
  const Released& release = *claim.plan.current();
  const ActionChunk& chunk = claim.plan.chunk_of(release);
  const auto first_row = static_cast<std::size_t>(first_open_tick() - chunk.start_tick);
  const std::size_t end_row = release.first_row + release.row_count;
  if (first_row == end_row) return;
  const FixedVec<Companion, max_claims> companions = companions_of(claim);
  Judgement judgement =
      judge_path(path_room_, path_plan_, claim.limits, hal_.state(), chunk, first_row, end_row,
                 row_before(claim), Companions(companions.begin(), companions.size()));
  if (judgement.evidence.ok()) return;
  if (drops) {
    judgement.outcome = Outcome::refused;
    judgement.row_count = 0;
  }
  release_rest(claim, judgement);
}

// What is left of the claim's release goes out again under a new verdict; if nothing is, it holds.
// The state that told has a lease due already.
void Gate::Core::release_rest(LiveClaim& claim, const Judgement& judgement) {
  const ActionChunk& chunk = claim.plan.chunk_of(*claim.plan.current());
  const std::uint64_t verdict_id = next_verdict_++;
  claim.latest_verdict = make_verdict(chunk, claim.source, judgement, verdict_id, now_ns_);
  (void)verdicts_.push_back(claim.latest_verdict);
  revoke_from(claim, first_open_tick() + judgement.row_count);
  if (judgement.outcome != Outcome::refused) {
    claim.plan.release_again(make_release(claim, judgement, verdict_id));
    return note_released(claim);
  }
  claim.plan.drop_current();
  claim.refused_tick = hal_.tick();
  claim.refused_verdict = verdict_id;
}

// In realtime the HAL goes on with rows that it has already. Without the SafeChunk that shortens
// them, the grant ends before the first that may not act. In lockstep each row needs a decision.
void Gate::Core::revoke_from(LiveClaim& claim, std::uint64_t tick) {
  if (hal_.lockstep()) return;
  claim.until_tick = std::min(claim.until_tick, tick - 1);
}

}  // namespace fairlead
