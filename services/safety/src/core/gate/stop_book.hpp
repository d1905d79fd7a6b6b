// Which stops are held, which were reset, and how often the gate itself had to stop.
#pragma once

#include <cstdint>

#include "fairlead_safety/fixed.hpp"
#include "fairlead_safety/limits.hpp"

namespace fairlead {

class StopBook {
 public:
  using Ids = FixedVec<std::uint64_t, max_stops>;

  /// Hold a stop. False if nothing changed: held already, or there is no room.
  bool hold(std::uint64_t id) {
    if (held_.contains(id)) return false;
    // When the list is full another stop stands for this one. Whoever raised it repeats it until a
    // lease lists it, so it is taken up as soon as another has been reset.
    return held_.push_back(id);
  }

  /// Clear one stop by its id; late copies of it are to be ignored from now on.
  bool reset(std::uint64_t id, std::uint64_t now_ns) {
    for (std::size_t i = 0; i < held_.size(); ++i) {
      if (held_[i] != id) continue;
      held_.erase_at(i);
      reset_[next_reset_++ % reset_.size()] = {id, now_ns};
      return true;
    }
    return false;
  }

  /// Whether this is a copy, still under way, of a stop that was reset. Copies come in a row:
  /// after 2 s without one the id is forgotten, and the same id is a stop like any other.
  bool is_late_copy(std::uint64_t id, std::uint64_t now_ns) {
    for (ResetStop& past : reset_) {
      if (past.id != id) continue;
      if (now_ns - past.copy_ns > forget_ns) {
        past = ResetStop{};
        return false;
      }
      past.copy_ns = now_ns;
      return true;
    }
    return false;
  }
  /// Forget that a stop was reset: its copies are no late ones.
  void forget(std::uint64_t id) {
    for (ResetStop& past : reset_)
      if (past.id == id) past = ResetStop{};
  }

  /// Note that the gate itself stops at `tick`; returns how often it has within `window` ticks.
  std::size_t note_raised(std::uint64_t tick, std::uint64_t window) {
    raised_.add(tick);
    return raised_.count(tick, window);
  }
  /// `last_tick`: of the session that has ended.
  void begin_session(std::uint64_t last_tick) { raised_.rebase(last_tick); }

  [[nodiscard]] const Ids& held() const { return held_; }

 private:
  struct ResetStop {
    std::uint64_t id = 0;  // ids of stops are never 0
    std::uint64_t copy_ns = 0;
  };
  static constexpr std::uint64_t forget_ns = 2'000'000'000;

  Ids held_;
  std::array<ResetStop, 256> reset_{};
  std::size_t next_reset_ = 0;
  TickWindow<16> raised_;
};

}  // namespace fairlead
