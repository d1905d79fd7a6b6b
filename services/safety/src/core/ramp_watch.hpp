// G043: what was told to stop has to be seen at standstill within the declared ramp.
#pragma once

#include <algorithm>
#include <cstdint>

namespace fairlead {

/// The time from a stop of an armed gate to the end of its ramp. In realtime the gate's clock
/// tells it, in lockstep the ticks of the states: a world that waits moves nothing.
class RampWatch {
 public:
  /// `tick`: of the newest state.
  void begin(std::uint64_t now_ns, std::uint64_t tick) {
    *this = RampWatch{};
    active_ = true;
    since_ns_ = now_ns;
    tick_ = tick;
  }
  void end() { active_ = false; }
  [[nodiscard]] bool active() const { return active_; }

  /// A new session counts its ticks anew.
  void begin_session() { tick_ = 0; }
  /// A new state. `still`: every part stands still after a tick in which no row moved it. A row
  /// that acts later takes that back; a hand that moves the robot does not.
  void see(std::uint64_t tick, bool acted, bool still) {
    if (tick_ != 0) ticks_ += tick - std::min(tick_, tick);
    tick_ = tick;
    seen_ = true;
    if (acted) still_ = false;
    if (still) still_ = true;
  }
  [[nodiscard]] bool still() const { return still_; }
  /// Whether there was a state at all.
  [[nodiscard]] bool seen() const { return seen_; }
  [[nodiscard]] std::uint64_t ns_since(std::uint64_t now_ns) const { return now_ns - since_ns_; }
  [[nodiscard]] std::uint64_t ticks_since() const { return ticks_; }

 private:
  bool active_ = false;
  bool still_ = false;
  bool seen_ = false;
  std::uint64_t since_ns_ = 0;
  std::uint64_t tick_ = 0;   // of the newest state, 0: none of this session
  std::uint64_t ticks_ = 0;  // since the stop
};

}  // namespace fairlead
