#include "core/release/claim_table.hpp"

#include <algorithm>

namespace fairlead {

void StoredFrame::store(Bytes frame) {
  // The frame has been decoded already, so it fits.
  std::copy(frame.begin(), frame.end(), bytes_.begin());
  size_ = frame.size();
}

void StoredChunk::store(Bytes frame) {
  StoredFrame::store(frame);
  (void)decode(this->frame(), chunk_);  // it has been decoded already, so it decodes again
}

bool StoredFrame::is_copy_of(Bytes frame) const {
  return size_ != 0 && std::equal(frame.begin(), frame.end(), bytes_.begin(),
                                  bytes_.begin() + static_cast<std::ptrdiff_t>(size_));
}

// The release that an act is a row of.
const Released* ReleasePlan::find(const Acted& act) const {
  if (act.hold != 0 || act.verdict_id == 0) return nullptr;
  for (const Released& release : releases_)
    if (release.verdict_id == act.verdict_id) return &release;
  return nullptr;
}

// What the HAL does in `tick` after `acted` in the tick before, going by what was released.
Acted ReleasePlan::follow(const Acted& acted, std::uint64_t tick) const {
  const Released* next = current();
  if (next != nullptr && next->first_tick == tick && same_act(next->after, acted))
    return Acted{0, next->verdict_id, 0};
  const Released* running = find(acted);
  if (running != nullptr && running->first_tick + acted.row + 1 == tick &&
      acted.row + 1 < running->row_count)
    return Acted{0, running->verdict_id, acted.row + 1};
  return Acted{static_cast<std::uint8_t>(Hold::no_row), 0, 0};
}

void ReleasePlan::begin_tick(std::uint64_t tick, const Acted& acted) {
  if (has_current_ && tick >= releases_[newest_].end_tick()) has_current_ = false;
  did_ = acted;
  expected_ = follow(acted, tick);
  if (!has_current_) {
    on_track_ = false;
    return;
  }
  Released& now = releases_[newest_];
  if (acted.hold == 0 && acted.verdict_id == now.verdict_id) now.seen = true;
  on_track_ = expected_.hold == 0 && expected_.verdict_id == now.verdict_id;
}

RowBefore ReleasePlan::row_of(const Acted& act) const {
  const Released* release = find(act);
  if (release == nullptr || act.row >= release->row_count) return {};
  return RowBefore{&chunk_of(*release), release->first_row + act.row};
}

Acted ReleasePlan::act_before(const Acted& act) const {
  const Released* release = find(act);
  if (release == nullptr) return Acted{};
  return act.row > 0 ? Acted{0, act.verdict_id, act.row - 1} : release->after;
}

bool ReleasePlan::uses_slot(const Acted& act, std::size_t slot) const {
  const Released* release = find(act);
  return release != nullptr && release->slot == slot;
}

// A stored candidate that neither the current release nor the rows that act now and before need:
// one of four always is.
std::size_t ReleasePlan::free_slot() const {
  std::size_t slot = (releases_[newest_].slot + 1) % slot_count;
  while (uses_slot(expected_, slot) || uses_slot(did_, slot)) slot = (slot + 1) % slot_count;
  return slot;
}

void ReleasePlan::remember(const Released& release) {
  if (++newest_ == releases_.size()) newest_ = 0;
  releases_[newest_] = release;
  has_current_ = true;
  on_track_ = true;
}

void ReleasePlan::release(Released release, Bytes frame) {
  release.slot = free_slot();
  for (Released& old : releases_)
    if (old.slot == release.slot) old.verdict_id = 0;  // its rows are about to be overwritten
  slots_[release.slot].store(frame);
  remember(release);
}

void ReleasePlan::release_again(Released release) {
  release.slot = releases_[newest_].slot;
  remember(release);
}

void ReleasePlan::clear() {
  releases_.fill(Released{});
  has_current_ = false;
  on_track_ = false;
  expected_ = did_ = Acted{};
}

bool LiveClaim::shares_parts_with(const LiveClaim& other) const {
  return std::any_of(limits.parts.begin(), limits.parts.end(),
                     [&](std::size_t part) { return other.covers(part); });
}

bool LiveClaim::has_parts_of(const LiveClaim& other) const {
  return limits.parts.size() == other.limits.parts.size() &&
         std::all_of(limits.parts.begin(), limits.parts.end(),
                     [&](std::size_t part) { return other.covers(part); });
}

PastSequence& ClaimLife::past_of(const Name& source) {
  for (PastSequence& one : past)
    if (one.source == source) return one;
  return past[past_count++ % past.size()] = {source, 0};
}

void LiveClaim::continue_as(const LiveClaim& next) {
  ClaimLife life;
  life.hal_follows = hal_follows;
  life.until_tick = until_tick;
  life.was_until_tick = was_until_tick;
  life.past = past;
  life.past_count = past_count;
  life.past_of(source).last_seq = last_seq;
  life.last_seq = life.past_of(next.source).last_seq;
  if (source == next.source) {  // offered to itself: what it may send is no more for that
    life.ahead = ahead;
    life.bad_frames = bad_frames;
    life.admitted = admitted;
  }
  life.refused_tick = refused_tick;
  life.refused_verdict = refused_verdict;
  static_cast<ClaimLife&>(*this) = life;
  source = next.source;
  skill = next.skill;
  limits = next.limits;
  admitted_limit = next.admitted_limit;
  admitted_window = next.admitted_window;
  newest.clear();
  waiting.clear();
}

}  // namespace fairlead
