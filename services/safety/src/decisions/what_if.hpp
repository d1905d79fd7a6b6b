// What another configuration would have answered to the recorded chunks.
//
// The robot's recorded states are what happened, not what would have happened. Where the other
// gate released what was released, they fit. Rows that it would not have released are shown to
// it as holds, as the robot would then have held; where the robot was is left as measured.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "decisions/replay.hpp"
#include "fairlead_safety/messages.hpp"

namespace fairlead {

struct ChangedVerdict {
  std::uint64_t tick = 0;  // newest state when the chunk was judged
  Verdict recorded;
  Verdict instead;
};

class WhatIf {
 public:
  /// `limits` must outlive it.
  explicit WhatIf(const Limits& limits) : replay_(limits) {}

  void feed(const Record& record, std::uint64_t tick);

  [[nodiscard]] const std::vector<ChangedVerdict>& changed() const { return changed_; }
  /// Chunks that the other gate could not judge: it had stopped, or had refused the claim.
  [[nodiscard]] std::uint64_t unjudged() const { return unjudged_; }
  /// Stops, latches and refused queries that the recorded gate did not have, in words.
  [[nodiscard]] const std::vector<std::string>& notes() const { return notes_; }

 private:
  struct Match {
    std::uint64_t verdict_id = 0;      // the other gate's, 0: it released nothing
    std::uint64_t released_first = 0;  // of the other gate
    std::uint64_t released_last = 0;
    std::uint64_t recorded_first = 0;
  };
  Bytes as_it_would_have_acted(Bytes state);
  void pair_verdicts(const Record& record, std::uint64_t tick);
  void compare(const Verdict& recorded, const Verdict* instead, std::uint64_t tick);
  void note_news(const Record& record, std::uint64_t tick);

  Replay replay_;
  std::map<std::uint64_t, Match> matches_;  // by recorded verdict id
  std::vector<ChangedVerdict> changed_;
  std::vector<std::string> notes_;
  std::uint64_t unjudged_ = 0;
  JointState state_;
  std::vector<std::uint8_t> frame_ = std::vector<std::uint8_t>(max_frame_bytes);
};

}  // namespace fairlead
