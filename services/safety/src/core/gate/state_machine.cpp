#include "core/gate/state_machine.hpp"

namespace fairlead {
namespace {

constexpr std::uint64_t ms = 1'000'000;
// How long copies of a reset stop may be under way after arming.
constexpr std::uint64_t copies_end_ns = 2'000'000'000;

}  // namespace

StateMachine::StateMachine(const Limits& limits, IdSource& ids, const HalLink& hal,
                           ClaimTable& claims, PartHistory& history, StopMonitor& stopping,
                           Outbox& outbox)
    : limits_(limits),
      ids_(ids),
      hal_(hal),
      claims_(claims),
      history_(history),
      stopping_(stopping),
      outbox_(outbox) {
  begin_epoch();
}

std::uint64_t StateMachine::new_id() {
  std::uint64_t id = 0;
  while (id == 0) id = ids_.next_id();
  return id;
}

void StateMachine::begin_epoch() {
  epoch_ = new_id();
  leases_.begin_epoch(epoch_);
  heard_foreign_lease_ = false;
}

void StateMachine::leave_overtaken_epoch() {
  if (heard_foreign_lease_) begin_epoch();
}

void StateMachine::set_state(GateState state, const Text& cause) {
  state_ = state;
  cause_ = cause;
  outbox_.announce();
  outbox_.log(cause);
}

Text StateMachine::fix() const {
  if (is(GateState::disarmed)) return "fairlead arm";
  if (is(GateState::stopped)) return phrase("fairlead reset ", Hex{stops_.held()[0]});
  if (is(GateState::latched)) return phrase("fairlead reset ", Hex{latch_id_});
  return {};
}

void StateMachine::boot(const BootInfo& info) {
  LatchRecord record;
  if (!info.latch.empty()) {
    const bool readable = decode(info.latch, record) == FrameFault::none && record.latch_id != 0;
    // Unreadable is no reason to forget it.
    latch_id_ = readable ? record.latch_id : new_id();
    set_state(GateState::latched, phrase("latched before the restart: ",
                                         readable ? record.cause.view() : "unreadable"));
    outbox_.persist_latch_due = !readable;
  } else if (info.first_start && !limits_.lockstep_allowed && !info.new_state) {
    // A state folder that went missing must not turn a latched robot into a clean one.
    latch("the state folder was never used before; start with --new-state if that is right");
  } else if (!info.first_start && !info.clean_mark) {
    latch("the last exit was not clean: armed, stopped or latched");
  } else {
    become_disarmed("started");
  }
}

void StateMachine::arm(const Text& cause) {
  // Leaving disarmed: should the process die from here on, it comes back latched.
  outbox_.out->add(OutputKind::clear_clean_mark);
  outbox_.clean_mark_due = false;
  begin_epoch();
  armed_ns_ = claimless_since_ns_ = outbox_.now_ns;
  set_state(GateState::armed, cause);
}

void StateMachine::become_disarmed(const Text& cause) {
  set_state(GateState::disarmed, cause);
  outbox_.clean_mark_due = true;
}

void StateMachine::disarm(const Text& cause) {
  end_claims("the gate was disarmed");
  become_disarmed(phrase("disarmed: ", cause));
}

void StateMachine::raise_stop(const Evidence& evidence) {
  if (state_ != GateState::armed) return;
  outbox_.count(evidence.code);
  stop_by_itself(words_of(evidence));
}

void StateMachine::stop_by_itself(const Text& cause) {
  const std::uint64_t window =
      limits_.protocol.stop_window_s * 1'000'000'000ULL / limits_.period_ns;
  if (stops_.note_raised(hal_.tick(), window) >= limits_.protocol.stops_to_latch)
    return latch(phrase(limits_.protocol.stops_to_latch, " stops in ",
                        limits_.protocol.stop_window_s, " s, the last: ", cause));
  hold_stop(new_id(), cause);
}

void StateMachine::hold_stop(std::uint64_t id, const Text& cause) {
  if (stops_.is_late_copy(id, outbox_.now_ns)) {
    // Whoever raised it lets go when a new epoch is armed: copies that go on are a new stop.
    const bool goes_on = state_ == GateState::armed && outbox_.now_ns - armed_ns_ > copies_end_ns;
    if (!goes_on) return ignore_copy(id);
    stops_.forget(id);
  }
  // The last place is for one that stands for all that find no other, and is reset by itself.
  const StopBook::Ids& held = stops_.held();
  const bool is_full = held.size() + 1 == max_stops && !held.contains(overflow_id_);
  if (is_full && !held.contains(id)) id = overflow_id_ = new_id();
  if (stops_.hold(id)) outbox_.announce();
  if (state_ != GateState::disarmed && state_ != GateState::armed) return;  // severity only rises
  if (state_ == GateState::disarmed) outbox_.out->add(OutputKind::clear_clean_mark);
  outbox_.clean_mark_due = false;
  begin_ramps();
  end_claims("the gate was stopped");
  set_state(GateState::stopped, phrase("stopped: ", cause));
}

// Counted every time; said once a second, since whoever repeats it does so every 50 ms.
void StateMachine::ignore_copy(std::uint64_t id) {
  ++outbox_.counters.stops_ignored;
  if (outbox_.now_ns - ignored_ns_ < 1'000'000'000) return;
  ignored_ns_ = outbox_.now_ns;
  outbox_.log(phrase("ignored a copy of stop ", Hex{id}, ", which was reset (",
                     outbox_.counters.stops_ignored, " ignored so far)"));
}

void StateMachine::latch(const Text& cause) {
  if (state_ == GateState::disarmed) outbox_.out->add(OutputKind::clear_clean_mark);
  outbox_.clean_mark_due = false;
  begin_ramps();
  end_claims("the gate latched");
  latch_id_ = new_id();
  leave_overtaken_epoch();
  good_states_ = 0;
  outbox_.persist_latch_due = true;
  set_state(GateState::latched, phrase("latched: ", cause));
}

void StateMachine::clear_latch() {
  latch_id_ = 0;
  leave_overtaken_epoch();
  outbox_.out->add(OutputKind::clear_latch);
}

void StateMachine::leave_stops(std::uint64_t reset_id, std::string_view by) {
  outbox_.announce();
  if (latch_id_ != 0) return;
  if (stops_.held().empty())
    become_disarmed(phrase("disarmed: ", Hex{reset_id}, " was reset by ", by));
  else
    set_state(GateState::stopped, phrase("stopped: ", Hex{stops_.held()[0]}, " is still held"));
}

void StateMachine::begin_ramps() {
  if (state_ == GateState::armed) stopping_.begin_all(outbox_.now_ns);
}

void StateMachine::end_claim(LiveClaim& claim, std::string_view reason) {
  outbox_.log(phrase("claim ", Hex{claim.id}, " of ", claim.source, " ended: ", reason));
  history_.keep(claim);
  stopping_.begin_of(claim, outbox_.now_ns);
  claim.id = 0;
  // Lockstep: the HAL executes no row of a tick before it has the lease that decides it.
  if (hal_.lockstep())
    claim.leave();
  else
    claim.leaves_by = hal_.last_granted_tick();
  claim.waiting.clear();
  claimless_since_ns_ = outbox_.now_ns;
  outbox_.announce();
}

void StateMachine::end_claims(std::string_view reason) {
  for (LiveClaim& claim : claims_.places())
    if (claim.live()) end_claim(claim, reason);
}

void StateMachine::begin_session() {
  stops_.begin_session(hal_.ended_tick());
  good_states_ = 0;
  stopping_.begin_session();
  history_.begin_session();
}

void StateMachine::check_deadlines() {
  if (!hal_.lockstep()) check_ramps();
  if (state_ != GateState::armed) return;
  const ProtocolLimits& protocol = limits_.protocol;
  const std::uint64_t now_ns = outbox_.now_ns;
  // G011: no new state for too long. In lockstep the world may wait for as long as it likes.
  if (!hal_.lockstep() && now_ns - hal_.arrival_ns() > protocol.state_timeout_ms * ms)
    return raise_stop(declared_as(
        above(code::state, "state age", static_cast<double>((now_ns - hal_.arrival_ns()) / ms),
              protocol.state_timeout_ms, "ms", "protocol state_timeout_ms"),
        "state_timeout_ms"));
  const std::uint64_t silence_ms = hal_.lockstep() ? protocol.heartbeat_timeout_lockstep_ms
                                                   : protocol.heartbeat_timeout_realtime_ms;
  for (LiveClaim& claim : claims_.places())
    if (claim.live() && now_ns - claim.heartbeat_ns > silence_ms * ms)
      end_claim(claim, "its heartbeat was lost");
  if (!claims_.empty()) claimless_since_ns_ = now_ns;
  if (now_ns - claimless_since_ns_ > protocol.idle_disarm_s * 1000 * ms)
    disarm(phrase("no claim for ", protocol.idle_disarm_s, " s"));
}

void StateMachine::check_ramps() {
  const Evidence evidence = stopping_.find_unstopped(outbox_.now_ns);
  if (evidence.ok()) return;
  latch_unstopped(evidence);
  stopping_.end_unstopped();
}

// What does not stop latches.
void StateMachine::latch_unstopped(const Evidence& evidence) {
  outbox_.count(code::ramp);
  const bool stopped = state_ == GateState::stopped || state_ == GateState::latched;
  const Text cause = phrase("no standstill ", limits_.protocol.stop_ramp_ms, " ms after the ",
                            stopped ? "stop: " : "end of its rows: ", words_of(evidence));
  if (state_ != GateState::latched) return latch(cause);
  // Latched already: the cause grows, and goes to the disk once more.
  set_state(GateState::latched, phrase(cause_, "; ", cause));
  good_states_ = 0;
  outbox_.persist_latch_due = true;
}

}  // namespace fairlead
