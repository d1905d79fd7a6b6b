// The live claims: who may move which parts, and everything remembered about each.
#pragma once

#include <array>
#include <cstdint>

#include "core/chunk/judgement.hpp"
#include "core/gate/tick_window.hpp"
#include "core/monitor/memory_guard.hpp"
#include "core/release/release_plan.hpp"
#include "fairlead_safety/messages.hpp"

namespace fairlead {

/// What is remembered of one claim's life; the next begins without any of it.
struct ClaimLife {
  bool hal_follows = false;  // the HAL has executed a row of this claim
  std::uint64_t last_seq = 0;
  TickWindow<16> ahead;       // G006: more than one tick ahead
  TickWindow<16> bad_frames;  // G001
  TickWindow<128> admitted;   // G010
  // No row for a later tick is granted until the HAL is known to have let go of what was revoked.
  std::uint64_t until_tick = UINT64_MAX;
  bool repeat = false;             // publish the current SafeChunk once more
  std::uint64_t refused_tick = 0;  // newest tick when a chunk was refused, 0: none
  std::uint64_t refused_verdict = 0;
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
  [[nodiscard]] bool covers(std::size_t part) const { return limits.parts.contains(part); }
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
      if (!claim.live()) return &claim;
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
