// The releases of all claims, moved on to each new state and judged again from it.
#pragma once

#include "core/chunk/judge_chunk.hpp"
#include "core/release/door.hpp"

namespace fairlead {

class LiveReleases {
 public:
  /// All must outlive it.
  LiveReleases(const HalLink& hal, ClaimTable& claims, const ActingRows& rows, ChunkJudge& judge,
               Door& door)
      : hal_(hal), claims_(claims), rows_(rows), judge_(judge), door_(door) {}

  /// Every claim's plan moves on to the newest state.
  void begin_tick();
  /// What the plans still hold is judged from the newest state, once all of them have moved on to
  /// it: each beside what the others then hold. Where one is cut, the others are judged once more,
  /// beside what it has left; where that goes on, a whole rest is dropped at a time, so that it
  /// ends.
  void judge();

 private:
  void begin_tick_of(LiveClaim& claim);
  void begin_tick_of_left(LiveClaim& claim);
  bool is_cut(LiveClaim& claim, bool drops, std::size_t queries);
  void judge_rest(LiveClaim& claim, bool drops, std::size_t queries);
  void judge_untaken(LiveClaim& claim, std::size_t queries);

  const HalLink& hal_;
  ClaimTable& claims_;
  const ActingRows& rows_;
  ChunkJudge& judge_;
  Door& door_;
  std::size_t queries_left_ = 0;  // of the newest state
};

}  // namespace fairlead
