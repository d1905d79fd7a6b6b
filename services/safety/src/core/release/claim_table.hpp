// What the gate has released for one claim, and what it therefore takes the HAL to do.
//
// The HAL may have received none, some or all of it. `acted` in the next state tells; until
// then the rules below predict: a chunk is taken at its first tick if what acted before is its
// `after`, a taken chunk goes on row by row, and anything else is a hold.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "core/chunk/judgement.hpp"
#include "core/monitor/memory_guard.hpp"
#include "fairlead_safety/codec.hpp"
#include "fairlead_safety/fixed.hpp"
#include "fairlead_safety/messages.hpp"

namespace fairlead {

/// The gate's own copy of a candidate's bytes.
class StoredFrame {
 public:
  void store(Bytes frame);
  void clear() { size_ = 0; }
  [[nodiscard]] bool empty() const { return size_ == 0; }
  [[nodiscard]] bool is_copy_of(Bytes frame) const;
  [[nodiscard]] Bytes frame() const { return Bytes(bytes_).first(size_); }

 private:
  std::size_t size_ = 0;
  std::array<std::uint8_t, max_frame_bytes> bytes_{};
};

/// The same, decoded in place.
class StoredChunk : public StoredFrame {
 public:
  void store(Bytes frame);
  [[nodiscard]] const ActionChunk& chunk() const { return chunk_; }

 private:
  ActionChunk chunk_;  // its NumberViews point into the frame's copy
};

/// One SafeChunk as the gate issued it.
struct Released {
  std::uint64_t verdict_id = 0;
  std::uint64_t judged_tick = 0;
  std::uint64_t first_tick = 0;
  std::uint32_t row_count = 0;
  std::size_t first_row = 0;  // of the candidate
  std::size_t slot = 0;       // which stored candidate
  Acted after;
  bool seen = false;  // `acted` has named it

  [[nodiscard]] std::uint64_t end_tick() const { return first_tick + row_count; }
};

class ReleasePlan {
 public:
  /// A new state: `acted` is what the claim's parts did in `tick` - 1.
  void begin_tick(std::uint64_t tick, const Acted& acted);

  /// The newest release while it has rows for the tick of the newest state or later.
  [[nodiscard]] const Released* current() const {
    return has_current_ ? &releases_[newest_] : nullptr;
  }
  /// False if the HAL did not take the current release, or has dropped it since.
  [[nodiscard]] bool on_track() const { return on_track_; }
  /// What the parts are taken to do in the tick of the newest state.
  [[nodiscard]] const Acted& expected() const { return expected_; }

  [[nodiscard]] const ActionChunk& chunk_of(const Released& release) const {
    return slots_[release.slot].chunk();
  }
  /// The candidate row behind an act, empty for a hold or an act that is not remembered.
  [[nodiscard]] RowBefore row_of(const Acted& act) const;

  /// What the claim did in the tick before a row that acted; a hold where that is not remembered.
  [[nodiscard]] Acted act_before(const Acted& act) const;

  /// Released rows of a new candidate. `release.slot` is chosen here.
  void release(Released release, Bytes frame);
  /// Released what is left of the current candidate again, under a new verdict.
  void release_again(Released release);
  /// Nothing more of the current release may run.
  void drop_current() { has_current_ = false; }
  void clear();

 private:
  [[nodiscard]] const Released* find(const Acted& act) const;
  [[nodiscard]] Acted follow(const Acted& acted, std::uint64_t tick) const;
  [[nodiscard]] bool uses_slot(const Acted& act, std::size_t slot) const;
  [[nodiscard]] std::size_t free_slot() const;
  void remember(const Released& release);

  static constexpr std::size_t slot_count = 4;
  std::array<StoredChunk, slot_count> slots_;
  std::array<Released, 16> releases_{};  // a ring; verdict_id 0: empty
  std::size_t newest_ = 0;
  bool has_current_ = false;
  bool on_track_ = false;
  Acted expected_;
  Acted did_;  // in the tick before
};

/// How far a source had got with its chunks when it handed its claim over.
struct PastSequence {
  Name source;
  std::uint64_t last_seq = 0;
};

/// What is remembered of one claim's life; the next begins without any of it.
struct ClaimLife {
  bool hal_follows = false;  // the HAL has executed a row of this claim
  std::uint64_t last_seq = 0;
  std::array<PastSequence, 8> past;  // of who held it: a ring
  std::size_t past_count = 0;
  TickWindow<16> ahead;       // G006: more than one tick ahead
  TickWindow<16> bad_frames;  // G001
  TickWindow<128> admitted;   // G010
  // No row for a later tick is granted until the HAL is known to have let go of what was revoked.
  std::uint64_t until_tick = UINT64_MAX;
  std::uint64_t was_until_tick = UINT64_MAX;  // in the newest lease before the newest state
  bool repeat = false;                        // publish the current SafeChunk once more
  std::uint64_t refused_tick = 0;             // newest tick when a chunk was refused, 0: none
  std::uint64_t refused_verdict = 0;
  Name offered_to;  // whose claim may go on with its rows; empty: nobody's
  // Of a claim that has ended (realtime): the newest tick for which a row of it was granted, which
  // the HAL may still execute. 0: none.
  std::uint64_t leaves_by = 0;

  /// How far this source had got when it handed the claim over; 0 if it never held it.
  PastSequence& past_of(const Name& source);
};

struct LiveClaim : ClaimLife {
  std::uint64_t id = 0;  // 0: this place is free
  Name source;
  Name skill;
  ClaimLimits limits;
  MemoryGuard guard;  // of limits, from admission on

  std::uint64_t heartbeat_ns = 0;  // when the last one arrived; the claim itself counts as one

  StoredFrame newest;      // G005: the last candidate that got a verdict of its own
  Verdict newest_verdict;  // the answer to it, and to its copies
  Verdict latest_verdict;  // that, or of what was judged again since; id 0: none yet
  StoredChunk waiting;     // G006: one tick ahead, until the next state
  std::size_t admitted_limit = 0;
  std::uint64_t admitted_window = 0;  // ticks

  ReleasePlan plan;
  SafeChunk safe_chunk;  // the plan's current release as it goes out

  [[nodiscard]] bool live() const { return id != 0; }
  /// It has ended, and a row of it may still act.
  [[nodiscard]] bool is_leaving() const { return id == 0 && leaves_by != 0; }
  /// After the last tick in which a row of its current release can act.
  [[nodiscard]] std::uint64_t end_tick_of(const Released& release) const {
    return live() ? release.end_tick() : std::min(release.end_tick(), leaves_by + 1);
  }
  /// None of its rows can act any more.
  void leave() {
    leaves_by = 0;
    plan.clear();
  }
  [[nodiscard]] bool covers(std::size_t part) const { return limits.parts.contains(part); }
  [[nodiscard]] bool shares_parts_with(const LiveClaim& other) const;
  [[nodiscard]] bool has_parts_of(const LiveClaim& other) const;
  /// Hand-over: under the same id, what it has released goes on; all else is that of `next`.
  void continue_as(const LiveClaim& next);
};

class ClaimTable {
 public:
  [[nodiscard]] bool empty() const {
    for (const LiveClaim& claim : claims_)
      if (claim.live()) return false;
    return true;
  }
  LiveClaim* find(std::uint64_t id) {
    for (LiveClaim& claim : claims_)
      if (claim.live() && claim.id == id) return &claim;
    return nullptr;
  }
  LiveClaim* free_place() {
    for (LiveClaim& claim : claims_)
      if (!claim.live() && !claim.is_leaving()) return &claim;
    return nullptr;
  }
  [[nodiscard]] const LiveClaim* holder_of(std::size_t part) const {
    for (const LiveClaim& claim : claims_)
      if (claim.live() && claim.covers(part)) return &claim;
    return nullptr;
  }
  /// Every place, free ones too (id 0).
  std::array<LiveClaim, max_claims>& places() { return claims_; }
  [[nodiscard]] const std::array<LiveClaim, max_claims>& places() const { return claims_; }

 private:
  std::array<LiveClaim, max_claims> claims_;
};

}  // namespace fairlead
