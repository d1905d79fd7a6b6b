// boot -> disarmed -> armed, and from any of them to stopped or latched; and what a change of state
// does to claims, stops and leases.
#pragma once

#include <cstdint>
#include <string_view>

#include "core/chunk/judgement.hpp"
#include "core/gate/outbox.hpp"
#include "core/monitor/stop_monitor.hpp"
#include "core/release/part_history.hpp"
#include "fairlead_safety/gate.hpp"

namespace fairlead {

/// Which stops are held, which were reset, and how often the gate itself had to stop.
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

class StateMachine {
 public:
  /// All must outlive it. Draws the first epoch.
  StateMachine(const Limits& limits, IdSource& ids, const HalLink& hal, ClaimTable& claims,
               PartHistory& history, StopMonitor& stopping, Outbox& outbox);

  [[nodiscard]] GateState state() const { return state_; }
  [[nodiscard]] bool is(GateState state) const { return state_ == state; }
  [[nodiscard]] bool is_armed() const { return state_ == GateState::armed; }
  [[nodiscard]] const Text& cause() const { return cause_; }
  /// The command that leads on from here, "" if none does.
  [[nodiscard]] Text fix() const;
  [[nodiscard]] std::uint64_t epoch() const { return epoch_; }
  [[nodiscard]] std::uint64_t latch_id() const { return latch_id_; }
  [[nodiscard]] const StopBook::Ids& stops() const { return stops_.held(); }
  /// Good joint states in a row since the latch or the last bad one.
  [[nodiscard]] std::uint64_t good_states() const { return good_states_; }
  /// The next lease to send. Any that this does not hold is another gate's.
  SentLeases& leases() { return leases_; }
  /// A lease that this gate did not send. Whoever followed it takes its own numbers for old ones,
  /// so latch and reset each begin a new epoch.
  void note_foreign_lease() {
    heard_foreign_lease_ = true;
    note_bad_state();  // while latched: the cause is still there
  }
  [[nodiscard]] std::uint64_t new_id();

  void boot(const BootInfo& info);
  /// Leaves disarmed, under a new epoch.
  void arm(const Text& cause);
  void disarm(const Text& cause);
  /// In disarmed: why it goes on.
  void say_cause(const Text& cause) { cause_ = cause; }
  /// A stop that the gate itself decided on, while armed. Too many within the window are no
  /// coincidence: latch.
  void raise_stop(const Evidence& evidence);
  void stop_by_itself(const Text& cause);
  /// A stop of anybody's, by its id.
  void hold_stop(std::uint64_t id, const Text& cause);
  void latch(const Text& cause);

  /// The latch is gone; `leave_stops` comes next.
  void clear_latch();
  /// False if no such stop is held.
  bool reset_stop(std::uint64_t id) { return stops_.reset(id, outbox_.now_ns); }
  /// A stop or latch was reset: to disarmed, if it was the last.
  void leave_stops(std::uint64_t reset_id, std::string_view by);

  void end_claim(LiveClaim& claim, std::string_view reason);

  void note_good_state() { ++good_states_; }
  void note_bad_state() { good_states_ = 0; }
  /// The HAL was started anew: its ticks count from 1 again.
  void begin_session();

  /// Everything that depends on the gate's own clock. Time is judged before the event is looked at,
  /// so that a process that slept does not act on what it slept through.
  void check_deadlines();
  /// G043.
  void check_ramps();

 private:
  void set_state(GateState state, const Text& cause);
  void become_disarmed(const Text& cause);
  void begin_epoch();
  void leave_overtaken_epoch();
  void begin_ramps();
  void ignore_copy(std::uint64_t id);
  void latch_unstopped(const Evidence& evidence);
  void end_claims(std::string_view reason);

  const Limits& limits_;
  IdSource& ids_;
  const HalLink& hal_;
  ClaimTable& claims_;
  PartHistory& history_;
  StopMonitor& stopping_;
  Outbox& outbox_;

  GateState state_ = GateState::boot;
  Text cause_ = "starting";
  std::uint64_t epoch_ = 0;
  SentLeases leases_;
  bool heard_foreign_lease_ = false;  // in this epoch
  StopBook stops_;
  std::uint64_t overflow_id_ = 0;  // of the stop that stands for those without a place; 0: none
  std::uint64_t latch_id_ = 0;
  std::uint64_t good_states_ = 0;
  std::uint64_t claimless_since_ns_ = 0;
  std::uint64_t armed_ns_ = 0;
  std::uint64_t ignored_ns_ = 0;  // when the last ignored stop was logged
};

}  // namespace fairlead
