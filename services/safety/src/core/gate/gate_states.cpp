// What the robot, the runners' heartbeats and the stop key say.

#include <algorithm>

#include "core/gate/gate_core.hpp"
#include "core/modes/bounds_recovery.hpp"
#include "core/modes/standstill.hpp"

namespace fairlead {
void Gate::Core::on_hal_status(Bytes frame) {
  const FrameFault fault = decode(frame, hal_status_);
  if (fault != FrameFault::none) {
    const Text text = phrase("the newest hal/status is unreadable: ", fault_name(fault));
    if (!(text == status_fault_)) log(text);  // it comes twice a second
    status_fault_ = text;
    return count(code::frame);
  }
  status_fault_.clear();
  on_session_news(hal_.take_status(hal_status_));
}

void Gate::Core::on_session_news(HalLink::News news) {
  if (news == HalLink::News::nothing) return;
  lease_due_ = status_due_ = true;
  if (news == HalLink::News::two_at_once) {
    log(two_hals());
    if (state_ == GateState::armed) return disarm(two_hals());
    if (state_ == GateState::disarmed) cause_ = two_hals();
    return;
  }
  if (news == HalLink::News::new_session) {
    log(phrase("following HAL session ", Hex{hal_.session()}));
    stops_.begin_session();
    good_states_ = 0;
    said_first_ = false;
    for (RampWatch& ramp : ramps_) ramp.begin_session();
    for (PartMemory& memory : memories_) memory.released = ReleasedRows{};
  }
  if (!hal_.mismatch().empty()) log(hal_.mismatch());
  if (state_ != GateState::armed) return;
  // What was armed is not there any more, or is not what it was.
  disarm(news == HalLink::News::new_session ? Text("a new HAL session")
                                            : phrase("the HAL changed: ", hal_change()));
}

// What fits the gate file on both sides of the change is the pacing.
Text Gate::Core::hal_change() const {
  if (!hal_.mismatch().empty()) return hal_.mismatch();
  return phrase("it paces in ", hal_.lockstep() ? "lockstep" : "realtime", " now");
}

// Another session that announced itself proves with a valid state that it is there.
void Gate::Core::on_rival_state(const JointState& message) {
  if (check_state(limits_, message).ok() && message.tick != 0)
    on_session_news(hal_.take_rival_state(now_ns_));
}

// When it came in, not when it got its turn: what waited behind a long step is no newer by that.
std::uint64_t Gate::Core::receipt_of(const Event& event) const {
  return std::min(event.received_ns, now_ns_);
}

void Gate::Core::on_joint_state(const Event& event) {
  if (decode(event.payload, joint_state_) != FrameFault::none) return count(code::frame);
  // G002 for states: another session's or another robot's say nothing about this one. Ignored all
  // the same, but not counted: any while no session is followed, and all but the first of one that
  // has announced itself.
  if (joint_state_.robot_hash != limits_.robot_hash) return count(code::session);
  if (joint_state_.session == hal_.rival() && hal_.rival() != 0) on_rival_state(joint_state_);
  if (joint_state_.session != hal_.session() || hal_.session() == 0) {
    if (hal_.session() != 0 && joint_state_.session != counted_rival_) count(code::session);
    if (joint_state_.session == hal_.rival()) counted_rival_ = joint_state_.session;
    return;
  }
  if (joint_state_.tick == 0 || joint_state_.tick < hal_.tick()) return;  // overtaken on the way
  if (!hal_.has_state() && joint_state_.tick > hal_.newest_first()) return refuse_first();
  Evidence evidence = check_state(limits_, joint_state_);
  if (evidence.ok()) evidence = check_leap(joint_state_.tick);
  if (!evidence.ok()) {
    good_states_ = 0;
    return raise_stop(evidence);
  }
  ++good_states_;
  lease_due_ = true;
  hal_.note_heard(receipt_of(event));
  if (hal_.has_state() && joint_state_.tick == hal_.tick())
    repeat_verdicts();  // a repeat: the world waits
  else
    on_new_tick(joint_state_, receipt_of(event));
  // Of a latch: one state at standstill may be a motion that turns around.
  if (!at_standstill(limits_, hal_.state())) good_states_ = 0;
}

// G013: nothing shows that a first tick is wrong but what the HAL says of itself; after one from
// the far future every honest state would look old.
void Gate::Core::refuse_first() {
  count(code::jump);
  if (said_first_) return;
  said_first_ = true;
  log(phrase("G013 the first joint state is of tick ", joint_state_.tick, ": expected at most ",
             hal_.newest_first(), ", ", unheard_ticks,
             " ticks after the newest hal/status; not taken"));
}

// G013: ticks are periods. A state that claims more of them than can have passed would excuse
// any jump and make later, honest ones look old: it is not taken. In lockstep a claim whose row
// the HAL executed makes it wait for a lease of each tick; without one it steps to standstill.
Evidence Gate::Core::check_leap(std::uint64_t tick) {
  if (!hal_.has_state()) return {};
  std::uint64_t newest = hal_.newest_possible(now_ns_);
  std::string_view rule = "the periods since the states before";
  bool can_leap = true;  // where a second state that agrees is believed
  if (hal_.lockstep()) {
    bool waits = false;
    for (const LiveClaim& claim : claims_.places()) waits |= claim.live() && claim.hal_follows;
    can_leap = waits;
    const std::uint64_t step = waits ? 1 : unheard_ticks;
    newest = hal_.tick() + std::min(step, UINT64_MAX - hal_.tick());
    rule = waits ? "lockstep: one tick for each lease" : "lockstep: ticks without a claim";
  }
  if (tick <= newest || (can_leap && hal_.confirms_leap(tick, now_ns_))) return {};
  return above(code::jump, "tick", static_cast<double>(tick - hal_.tick()),
               static_cast<double>(newest - hal_.tick()), rule);
}

// What the runner may have missed, as long as the world waits for it: identical bytes.
void Gate::Core::repeat_verdicts() {
  if (!hal_.lockstep() || state_ != GateState::armed) return;
  for (const LiveClaim& claim : claims_.places())
    if (claim.live() && claim.latest_verdict.verdict_id != 0)
      (void)verdicts_.push_back(claim.latest_verdict);
}

// No row is refused because of these joints; but it is said and counted.
void Gate::Core::note_unmoved_joints() {
  for (std::size_t i = 0; i < limits_.measured_count(); ++i) {
    const UnmovedJoint joint = unmoved_joint(limits_, i);
    if (joint.bounds == nullptr) continue;
    const double measured = hal_.state().positions[i];
    const bool outside = is_outside(*joint.bounds, measured);
    if (outside == said_outside_[i]) continue;
    said_outside_[i] = outside;
    if (outside) count(code::state);
    log(phrase("G011 ", joint.kind, " joint ", joint.name, " is ",
               outside ? "outside" : "back inside", " its limits: ", measured));
  }
}

void Gate::Core::on_new_tick(const JointState& message, std::uint64_t received_ns) {
  const MeasuredState before = hal_.state();
  seen_tick_ = hal_.tick();
  hal_.take_state(message, received_ns);
  note_unmoved_joints();
  watch_ramps();
  if (state_ != GateState::armed) return forget_held();
  if (jump_memory_) {
    const Evidence evidence = check_jump(limits_, before, hal_.state());
    if (!evidence.ok()) return raise_stop(evidence);
  }
  const Evidence moved = watch_motion(before);
  if (!moved.ok()) return raise_stop(moved);
  jump_memory_ = true;
  update_memories(before);
  for (LiveClaim& claim : claims_.places())
    if (claim.live()) begin_tick_of(claim);
  judge_live();
  const Evidence running = check_live_rows();
  if (!running.ok()) return raise_stop(running);
  for (LiveClaim& claim : claims_.places()) {
    if (!claim.live() || claim.waiting.empty()) continue;
    const Name source = claim.source;
    chunk_ = claim.waiting.chunk();
    take_chunk(chunk_, claim.waiting.frame(), source, now_ns_);
    claim.waiting.clear();
  }
}

void Gate::Core::on_heartbeat(const Event& event) {
  Heartbeat heartbeat;
  if (decode(event.payload, heartbeat) != FrameFault::none) return count(code::frame);
  LiveClaim* claim = claims_.find(heartbeat.claim_id);
  // Only its own runner keeps a claim alive.
  if (claim == nullptr || !(claim->source == event.source)) return;
  claim->heartbeat_ns = std::max(claim->heartbeat_ns, receipt_of(event));
}

void Gate::Core::on_stop_level(Bytes frame) {
  StopLevel level;
  if (decode(frame, level) == FrameFault::none && level.stop_id != 0)
    return hold_stop(level.stop_id, phrase("by ", level.by, ": ", level.reason));
  // Somebody wanted a stop. Without an id it gets one here, once.
  count(code::frame);
  if (stops_.held().empty()) hold_stop(new_id(), "an unreadable stop request");
}

// Only a second gate, or a forger, publishes leases that this one never sent. Which of the two the
// HAL follows is a matter of luck, so neither may move anything.
void Gate::Core::on_lease(Bytes frame) {
  if (decode(frame, heard_lease_) != FrameFault::none) return count(code::frame);
  if (leases_.holds(heard_lease_)) return;
  good_states_ = 0;  // while latched: the cause is still there
  if (state_ != GateState::latched)
    latch(phrase("two gates serve this robot: lease ", heard_lease_.lease_seq, " of epoch ",
                 Hex{heard_lease_.epoch}, ", which this one did not send"));
}

}  // namespace fairlead
