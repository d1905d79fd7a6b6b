// What the gate has released for one claim, and what it therefore takes the HAL to do.
//
// The HAL may have received none, some or all of it. `acted` in the next state tells; until
// then the rules below predict: a chunk is taken at its first tick if what acted before is its
// `after`, a taken chunk goes on row by row, and anything else is a hold.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "core/chunk/judgement.hpp"
#include "fairlead_safety/codec.hpp"
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
  [[nodiscard]] const Released* find(std::uint64_t verdict_id) const;
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

}  // namespace fairlead
