#include "core/release/live_releases.hpp"

#include <algorithm>

namespace fairlead {
namespace {

bool holds_rows(const LiveClaim& claim) { return claim.live() && claim.plan.current() != nullptr; }

}  // namespace

void LiveReleases::begin_tick() {
  for (LiveClaim& claim : claims_.places()) {
    if (claim.live()) begin_tick_of(claim);
    if (claim.is_leaving()) begin_tick_of_left(claim);
  }
}

// Until a state shows that the parts hold, or no lease grants its rows any more.
void LiveReleases::begin_tick_of_left(LiveClaim& claim) {
  claim.plan.begin_tick(hal_.tick(), rows_.acted_of(claim));
  if (claim.plan.expected().hold != 0 || hal_.tick() > claim.leaves_by) claim.leave();
}

void LiveReleases::begin_tick_of(LiveClaim& claim) {
  const Acted acted = rows_.acted_of(claim);
  ReleasePlan& plan = claim.plan;
  claim.was_until_tick = claim.until_tick;
  claim.hal_follows = claim.hal_follows || plan.row_of(acted).chunk != nullptr;
  plan.begin_tick(hal_.tick(), acted);
  const Released* release = plan.current();
  // A hold, and a row of the newest release, end whatever the HAL had before.
  if (acted.hold != 0 || (release != nullptr && acted.verdict_id == release->verdict_id))
    claim.until_tick = UINT64_MAX;
  // Rows run on that a later release, which the HAL did not take in time, had replaced: nobody
  // certifies them any more.
  const bool is_newest = release != nullptr && plan.expected().verdict_id == release->verdict_id;
  const bool is_forgotten = acted.hold == 0 && plan.row_of(acted).chunk == nullptr;
  if ((plan.expected().hold == 0 && !is_newest) || is_forgotten)
    door_.revoke_from(claim, rows_.first_open_tick());
}

// All claims together query as many configurations as one judgement may, none more than its share.
void LiveReleases::judge() {
  static_assert(max_claims <= 32);
  constexpr int rounds_that_cut = 2;
  std::uint32_t due = (1U << max_claims) - 1U;
  const auto& claims = claims_.places();
  const auto holders = std::count_if(claims.begin(), claims.end(), holds_rows);
  const std::size_t share =
      max_queries / std::max<std::size_t>(1, static_cast<std::size_t>(holders));
  queries_left_ = max_queries;
  for (int round = 0; due != 0; ++round) {
    std::uint32_t bit = 1;
    for (LiveClaim& claim : claims_.places()) {
      const bool asked = (due & bit) != 0 && holds_rows(claim);
      due &= ~bit;
      if (asked && is_cut(claim, round >= rounds_that_cut, std::min(share, queries_left_)))
        due |= ((1U << max_claims) - 1U) & ~bit;
      bit <<= 1U;
    }
  }
}

// Whether the claim has fewer rows left than it had.
bool LiveReleases::is_cut(LiveClaim& claim, bool drops, std::size_t queries) {
  const std::uint64_t end_tick = claim.plan.current()->end_tick();
  // The HAL did something else than expected: all of what is left goes out again.
  if (!claim.plan.on_track())
    judge_untaken(claim, queries);
  else
    judge_rest(claim, drops, queries);
  const Released* left = claim.plan.current();
  return left == nullptr || left->end_tick() < end_tick;
}

// G024, G030 to G034: what is left may not lead where it may not, as the newest state tells. The
// row that acts already (realtime) is past recall; those after it are not.
void LiveReleases::judge_rest(LiveClaim& claim, bool drops, std::size_t queries) {
  const Released& release = *claim.plan.current();
  const ActionChunk& chunk = claim.plan.chunk_of(release);
  const auto first_row = static_cast<std::size_t>(rows_.first_open_tick() - chunk.start_tick);
  const std::size_t end_row = release.first_row + release.row_count;
  if (first_row == end_row) return;
  Judgement judgement = judge_.judge_again(claim, chunk, first_row, end_row, queries);
  queries_left_ -= judgement.configurations;
  if (judgement.evidence.ok()) return;
  if (drops) {
    judgement.outcome = Outcome::refused;
    judgement.row_count = 0;
  }
  door_.answer_rest(claim, judgement);
}

// After the HAL did something else: what is left, from the newest state, under a new verdict.
void LiveReleases::judge_untaken(LiveClaim& claim, std::size_t queries) {
  const Released old = *claim.plan.current();
  const ActionChunk& chunk = claim.plan.chunk_of(old);
  const auto first_row = static_cast<std::size_t>(rows_.first_open_tick() - chunk.start_tick);
  const std::size_t end_row = old.first_row + old.row_count;
  if (first_row >= end_row) {
    door_.revoke_from(claim, rows_.first_open_tick());
    return claim.plan.drop_current();
  }
  Judgement judgement = judge_.judge_from(claim, chunk, first_row, queries);
  queries_left_ -= judgement.configurations;
  // Rows that were cut off once stay cut off.
  judgement.row_count = std::min(judgement.row_count, end_row - first_row);
  door_.answer_rest(claim, judgement);
}

}  // namespace fairlead
