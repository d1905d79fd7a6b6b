// G043: a part whose permission to move ended has to be seen at standstill within the ramp.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>

#include "core/chunk/judgement.hpp"
#include "core/gate/hal_link.hpp"
#include "core/release/claim_table.hpp"
#include "core/release/part_history.hpp"

namespace fairlead {

/// One part, from the end of its permission to its standstill. In realtime the gate's clock tells
/// the time, in lockstep the ticks of the states: a world that waits moves nothing.
class RampWatch {
 public:
  /// One sample below a limit may be noise, or a motion that turns around.
  static constexpr std::uint32_t still_states = 3;

  /// A row moved the part, as it was permitted to: what was watched is watched anew from its end.
  void move() {
    active_ = false;
    moved_ = true;
  }
  /// Permission ended. A watch that runs goes on. `tick`: of the newest state.
  void begin(std::uint64_t now_ns, std::uint64_t tick) {
    if (active_) return;
    *this = RampWatch{};
    active_ = true;
    since_ns_ = now_ns;
    tick_ = tick;
  }
  void end() { active_ = false; }
  [[nodiscard]] bool active() const { return active_; }
  /// A row moved it, and nothing watches yet whether it stops.
  [[nodiscard]] bool moved() const { return moved_; }

  /// A new session counts its ticks anew.
  void begin_session() { tick_ = 0; }
  /// A new state. `still`: the part stands still after a tick in which no row moved it. So often
  /// in a row, and it has stopped: a hand that moves it later does not take that back.
  void see(std::uint64_t tick, bool still) {
    if (tick_ != 0) ticks_ += tick - std::min(tick_, tick);
    tick_ = tick;
    seen_ = true;
    still_ = still ? still_ + 1 : 0;
    if (still_ >= still_states) end();
  }
  /// States at standstill, one after the other, up to the newest.
  [[nodiscard]] std::uint32_t still() const { return still_; }
  /// Whether there was a state at all.
  [[nodiscard]] bool seen() const { return seen_; }
  [[nodiscard]] std::uint64_t ns_since(std::uint64_t now_ns) const { return now_ns - since_ns_; }
  [[nodiscard]] std::uint64_t ticks_since() const { return ticks_; }

 private:
  bool active_ = false;
  bool moved_ = false;
  bool seen_ = false;
  std::uint32_t still_ = 0;
  std::uint64_t since_ns_ = 0;
  std::uint64_t tick_ = 0;   // of the newest state, 0: none of this session
  std::uint64_t ticks_ = 0;  // since the permission ended
};

class StopMonitor {
 public:
  /// Both must outlive the monitor.
  StopMonitor(const Limits& limits, const HalLink& hal) : limits_(limits), hal_(hal) {}

  /// After a stop every part has to be seen at standstill, whoever moved it.
  void begin_all(std::uint64_t now_ns);
  /// A claim that ends leaves its parts to their hold law.
  void begin_of(const LiveClaim& claim, std::uint64_t now_ns);
  /// A new session counts its ticks anew.
  void begin_session();
  /// The newest state.
  void see(const ClaimTable& claims, const PartHistory& history, bool is_armed,
           std::uint64_t now_ns);

  /// The first part that has not come to standstill in time: which joint of it, or which silence.
  Evidence find_unstopped(std::uint64_t now_ns);
  /// All that were found then have been told: they are watched no longer.
  void end_unstopped();

 private:
  [[nodiscard]] Evidence why_unstopped(std::size_t index, std::uint64_t now_ns) const;

  const Limits& limits_;
  const HalLink& hal_;
  std::array<RampWatch, max_parts> ramps_;   // since each part's permission ended
  std::array<bool, max_parts> unstopped_{};  // as found last
};

}  // namespace fairlead
