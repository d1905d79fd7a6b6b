// Which stops are held, which were reset, and how often the gate itself had to stop.
#pragma once

#include <cstdint>

#include "fairlead_safety/fixed.hpp"
#include "fairlead_safety/limits.hpp"
#include "tick_window.hpp"

namespace fairlead {

class StopBook {
 public:
  using Ids = FixedVec<std::uint64_t, max_stops>;

  /// Hold a stop. False if nothing changed: held already, or a late copy of one that was reset.
  bool hold(std::uint64_t id) {
    if (held_.contains(id) || was_reset(id)) return false;
    // When the list is full the robot is stopped anyway; whoever raised this one repeats it
    // until a lease lists it, so it is taken up as soon as another has been reset.
    return held_.push_back(id);
  }

  /// Clear one stop by its id; its late copies are ignored from now on.
  bool reset(std::uint64_t id) {
    for (std::size_t i = 0; i < held_.size(); ++i) {
      if (held_[i] != id) continue;
      held_.erase_at(i);
      reset_[next_reset_++ % reset_.size()] = id;
      return true;
    }
    return false;
  }

  [[nodiscard]] bool was_reset(std::uint64_t id) const {
    for (const std::uint64_t past : reset_)
      if (past == id) return true;
    return false;
  }

  /// Note that the gate itself stops at `tick`; returns how often it has within `window` ticks.
  std::size_t note_raised(std::uint64_t tick, std::uint64_t window) {
    raised_.add(tick);
    return raised_.count(tick, window);
  }
  void begin_session() { raised_.rebase(); }

  [[nodiscard]] const Ids& held() const { return held_; }

 private:
  Ids held_;
  std::array<std::uint64_t, 256> reset_{};  // ids are never 0
  std::size_t next_reset_ = 0;
  TickWindow<16> raised_;
};

}  // namespace fairlead
