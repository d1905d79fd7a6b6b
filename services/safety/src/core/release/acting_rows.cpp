#include "core/release/acting_rows.hpp"

#include <algorithm>

namespace fairlead {
namespace {

bool share_a_part(const ActionChunk* one, const ActionChunk& other) {
  if (one == nullptr) return false;
  for (const ActionPart& action : one->parts)
    for (const ActionPart& taken : other.parts)
      if (action.part == taken.part) return true;
  return false;
}

bool acts_beside(const LiveClaim& claim, const LiveClaim& other) {
  return other.live() ? other.id != claim.id : other.is_leaving();
}

}  // namespace

Acted ActingRows::acted_of(const LiveClaim& claim) const {
  constexpr Acted unknown{.hold = 0};
  const FixedVec<Acted, max_parts>& acted = hal_.state().acted;
  Acted act = acted[claim.limits.parts[0]];
  for (const std::size_t part : claim.limits.parts) {
    if (acted[part].hold != 0) continue;
    if (act.hold == 0 && !same_act(act, acted[part])) return unknown;
    act = acted[part];
  }
  const RowBefore row = claim.plan.row_of(act);
  if (row.chunk == nullptr) return act;
  for (const ActionPart& part : row.chunk->parts)
    if (acted[part.part].hold != 0) return unknown;
  return act;
}

bool ActingRows::knows_act_before(const LiveClaim& claim) const {
  const Acted act = act_before(claim);
  return act.hold != 0 || claim.plan.row_of(act).chunk != nullptr;
}

RowBefore ActingRows::row_before(const LiveClaim& claim) const {
  RowBefore before = claim.plan.row_of(act_before(claim));
  before.measured = hal_.lockstep();
  before.memories = &history_.memories();
  return before;
}

FixedVec<Companion, max_claims> ActingRows::companions_of(const LiveClaim& claim,
                                                          const ActionChunk& chunk,
                                                          bool holding) const {
  FixedVec<Companion, max_claims> companions;
  for (const LiveClaim& other : claims_.places()) {
    if (!acts_beside(claim, other) || (holding && may_hold(other))) continue;
    Companion companion = companion_of(other);
    if (!other.live() && share_a_part(companion.before.chunk, chunk))
      companion.before.chunk = nullptr;
    if (!other.live() && share_a_part(companion.chunk, chunk)) companion.chunk = nullptr;
    (void)companions.push_back(companion);
  }
  return companions;
}

bool ActingRows::may_hold(const LiveClaim& other) const {
  return !hal_.lockstep() && other.plan.expected().hold == 0 &&
         (!other.live() || other.was_until_tick < hal_.tick());
}

bool ActingRows::others_may_hold(const LiveClaim& claim) const {
  return std::ranges::any_of(claims_.places(), [&](const LiveClaim& other) {
    return acts_beside(claim, other) && may_hold(other);
  });
}

Companion ActingRows::companion_of(const LiveClaim& other) const {
  Companion companion{row_before(other)};
  const Released* release = other.plan.current();
  // Rows are released from the first open tick on, never later.
  if (release != nullptr &&
      first_open_tick() >= release->first_tick) {  // GCOVR_EXCL_BR_LINE: see above
    companion.chunk = &other.plan.chunk_of(*release);
    companion.row = release->first_row + (first_open_tick() - release->first_tick);
    companion.end_row = release->first_row + (other.end_tick_of(*release) - release->first_tick);
  }
  return companion;
}

Evidence ActingRows::check_running_rows() const {
  for (const LiveClaim& claim : claims_.places()) {
    if (!claim.live()) continue;
    Acted next = claim.plan.expected();
    if (!hal_.lockstep()) ++next.row;  // the row of this tick acts already
    const RowBefore row = claim.plan.row_of(next);
    if (row.chunk == nullptr) continue;
    const Evidence evidence =
        check_running(model_, claim.limits, hal_.state(), *row.chunk, row.row);
    if (!evidence.ok()) return evidence;
  }
  return {};
}

}  // namespace fairlead
