#include "core/gate/robot_events.hpp"

#include <algorithm>

#include "core/chunk/state_check.hpp"
#include "core/modes/row_limit_check.hpp"

namespace fairlead {

void RobotEvents::on_hal_status(Bytes frame) {
  const FrameFault fault = decode(frame, hal_status_);
  if (fault != FrameFault::none) {
    const Text text = phrase("the newest hal/status is unreadable: ", fault_name(fault));
    if (!(text == status_fault_)) outbox_.log(text);  // it comes twice a second
    status_fault_ = text;
    return outbox_.count(code::frame);
  }
  status_fault_.clear();
  on_session_news(hal_.take_status(hal_status_));
}

Text two_hals(const HalLink& hal) {
  return phrase("two HALs publish for this robot: sessions ", Hex{hal.session()}, " and ",
                Hex{hal.rival()});
}

void RobotEvents::on_session_news(HalLink::News news) {
  if (news == HalLink::News::nothing) return;
  outbox_.announce();
  if (news == HalLink::News::two_at_once) {
    outbox_.log(two_hals(hal_));
    if (machine_.is_armed()) return machine_.disarm(two_hals(hal_));
    if (machine_.is(GateState::disarmed)) machine_.say_cause(two_hals(hal_));
    return;
  }
  if (news == HalLink::News::new_session) {
    outbox_.log(phrase("following HAL session ", Hex{hal_.session()}));
    machine_.begin_session();
    said_first_ = false;
  }
  if (!hal_.mismatch().empty()) outbox_.log(hal_.mismatch());
  if (!machine_.is_armed()) return;
  // What was armed is not there any more, or is not what it was.
  machine_.disarm(news == HalLink::News::new_session ? Text("a new HAL session")
                                                     : phrase("the HAL changed: ", hal_change()));
}

// What fits the gate file on both sides of the change is the pacing.
Text RobotEvents::hal_change() const {
  if (!hal_.mismatch().empty()) return hal_.mismatch();
  return phrase("it paces in ", hal_.lockstep() ? "lockstep" : "realtime", " now");
}

// Another session that announced itself proves with a valid state that it is there.
void RobotEvents::on_rival_state() {
  if (check_state(limits_, joint_state_).ok() && joint_state_.tick != 0)
    on_session_news(hal_.take_rival_state(outbox_.now_ns));
}

// When it came in, not when it got its turn: what waited behind a long step is no newer by that.
std::uint64_t RobotEvents::receipt_of(const Event& event) const {
  return std::min(event.received_ns, outbox_.now_ns);
}

// One HAL says one thing of each tick. An older one may be a late copy: of that nothing is known.
bool RobotEvents::is_anothers() const {
  return hal_.has_state() && joint_state_.tick == hal_.tick() && !hal_.repeats(joint_state_);
}

// Which of the two is the HAL nobody can tell, so nothing may move.
void RobotEvents::stop_for_another() {
  outbox_.count(code::session);
  machine_.note_bad_state();
  if (!machine_.is_armed()) return;
  machine_.stop_by_itself(phrase("two HALs publish for this robot: a second state of tick ",
                                 joint_state_.tick, " of session ", Hex{joint_state_.session},
                                 "; the newest is of tick ", hal_.tick()));
}

// The HAL executes what it takes for this gate's.
Text RobotEvents::forged_row() const {
  const FixedVec<Acted, max_parts>& acted = hal_.state().acted;
  for (std::size_t i = 0; i < acted.size(); ++i)
    if (acted[i].hold == 0 && !door_.has_released(i, acted[i]))
      return phrase("two gates serve this robot: ", limits_.parts[i].name, " executed row ",
                    acted[i].row, " of verdict ", acted[i].verdict_id,
                    ", which this one did not release");
  return {};
}

void RobotEvents::on_joint_state(const Event& event) {
  if (decode(event.payload, joint_state_) != FrameFault::none) return outbox_.count(code::frame);
  // G002 for states: another session's or another robot's say nothing about this one. Ignored all
  // the same, but not counted: any while no session is followed, and all but the first of one that
  // has announced itself.
  if (joint_state_.robot_hash != limits_.robot_hash) return outbox_.count(code::session);
  if (joint_state_.session == hal_.rival() && hal_.rival() != 0) on_rival_state();
  if (joint_state_.session != hal_.session() || hal_.session() == 0) {
    if (hal_.session() != 0 && joint_state_.session != counted_rival_) outbox_.count(code::session);
    if (joint_state_.session == hal_.rival()) counted_rival_ = joint_state_.session;
    return;
  }
  if (joint_state_.tick == 0 || joint_state_.tick < hal_.tick()) return;  // overtaken on the way
  if (!hal_.has_state() && joint_state_.tick > hal_.newest_first()) return refuse_first();
  Evidence evidence = check_state(limits_, joint_state_);
  if (evidence.ok()) evidence = check_leap(joint_state_.tick, receipt_of(event));
  if (!evidence.ok()) {
    machine_.note_bad_state();
    return machine_.raise_stop(evidence);
  }
  if (is_anothers()) return stop_for_another();
  const bool repeats = hal_.has_state() && joint_state_.tick == hal_.tick();
  if (repeats && !hal_.lockstep()) return;  // a copy: in realtime each tick is said once
  machine_.note_good_state();
  outbox_.lease_due = true;
  hal_.note_heard(receipt_of(event));
  if (repeats) {
    hal_.note_repeat();
    repeat_verdicts();  // the world waits
  } else {
    on_new_tick(receipt_of(event));
  }
  // Of a latch: one state at standstill may be a motion that turns around.
  if (!at_standstill(limits_, hal_.state())) machine_.note_bad_state();
}

void RobotEvents::on_new_tick(std::uint64_t received_ns) {
  const MeasuredState before = hal_.state();
  history_.end_tick(hal_.tick());
  hal_.take_state(joint_state_, received_ns);
  note_unmoved_joints();
  stopping_.see(claims_, history_, machine_.is_armed(), outbox_.now_ns);
  machine_.check_ramps();
  if (!machine_.is_armed()) return move_on_disarmed();
  if (const Text forged = forged_row(); !forged.empty()) return machine_.latch(forged);
  const Evidence moved = motion_.check(before, hal_.state(), claims_);
  if (!moved.ok()) return machine_.raise_stop(moved);
  history_.update(before, hal_.state(), claims_);
  releases_.begin_tick();
  releases_.judge();
  const Evidence running = rows_.check_running_rows();
  if (!running.ok()) return machine_.raise_stop(running);
  candidates_.take_waiting();
}

// Rows of claims that have ended may still act when the gate is armed anew.
void RobotEvents::move_on_disarmed() {
  releases_.begin_tick();
  history_.forget_held(hal_.state());
}

// G013: nothing shows that a first tick is wrong but what the HAL says of itself; after one from
// the far future every honest state would look old.
void RobotEvents::refuse_first() {
  outbox_.count(code::jump);
  if (said_first_) return;
  said_first_ = true;
  outbox_.log(phrase("G013 the first joint state is of tick ", joint_state_.tick,
                     ": expected at most ", hal_.newest_first(), ", ", unheard_ticks,
                     " ticks after the newest hal/status; not taken"));
}

// G013: ticks are periods. A state that claims more of them than can have passed would excuse
// any jump and make later, honest ones look old: it is not taken. In lockstep a claim whose row
// the HAL executed makes it wait for a lease of each tick; without one it steps to standstill.
Evidence RobotEvents::check_leap(std::uint64_t tick, std::uint64_t received_ns) {
  if (!hal_.has_state()) return {};
  std::uint64_t newest = hal_.newest_possible(received_ns);
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
  if (tick <= newest || (can_leap && hal_.confirms_leap(tick, received_ns))) return {};
  return declared_as(above(code::jump, "tick", static_cast<double>(tick - hal_.tick()),
                           static_cast<double>(newest - hal_.tick()), "ticks", rule),
                     rule);
}

// What the runner may have missed, as long as the world waits for it: identical bytes.
void RobotEvents::repeat_verdicts() {
  if (!machine_.is_armed()) return;
  for (const LiveClaim& claim : claims_.places())
    if (claim.live() && claim.latest_verdict.verdict_id != 0) outbox_.tell(claim.latest_verdict);
}

namespace {

// A measured joint for which no row is refused: a passive one, which nothing moves, or a gripper's,
// whose targets all lead back. "" of any other.
std::string_view kind_of_unmoved(const Limits& limits, std::size_t i) {
  if (i >= limits.joints.size()) return "passive";
  return only_grips(limits.parts[limits.joints[i].part].modes) ? "gripper" : "";
}

}  // namespace

// It is said and counted all the same.
void RobotEvents::note_unmoved_joints() {
  for (std::size_t i = 0; i < limits_.measured_count(); ++i) {
    const std::string_view kind = kind_of_unmoved(limits_, i);
    if (kind.empty()) continue;
    const double measured = hal_.state().positions[i];
    const bool outside = is_outside(limits_.measured(i).bounds, measured);
    if (outside == said_outside_[i]) continue;
    said_outside_[i] = outside;
    if (outside) outbox_.count(code::state);
    outbox_.log(phrase("G011 ", kind, " joint ", limits_.measured(i).name, " is ",
                       outside ? "outside" : "back inside", " its limits: ", measured));
  }
}

void RobotEvents::on_heartbeat(const Event& event) {
  Heartbeat heartbeat;
  if (decode(event.payload, heartbeat) != FrameFault::none) return outbox_.count(code::frame);
  LiveClaim* claim = claims_.find(heartbeat.claim_id);
  // Only its own runner keeps a claim alive.
  if (claim == nullptr || !(claim->source == event.source)) return;
  claim->heartbeat_ns = std::max(claim->heartbeat_ns, receipt_of(event));
}

void RobotEvents::on_stop_level(Bytes frame) {
  StopLevel level;
  if (decode(frame, level) == FrameFault::none && level.stop_id != 0)
    return machine_.hold_stop(level.stop_id, phrase("by ", level.by, ": ", level.reason));
  // Somebody wanted a stop. Without an id it gets one here, once.
  outbox_.count(code::frame);
  if (machine_.stops().empty()) machine_.hold_stop(machine_.new_id(), "an unreadable stop request");
}

// Only a second gate, or a forger, publishes leases that this one never sent. Which of the two the
// HAL follows is a matter of luck, so neither may move anything.
void RobotEvents::on_lease(Bytes frame) {
  if (decode(frame, heard_lease_) != FrameFault::none) return outbox_.count(code::frame);
  if (machine_.leases().holds(heard_lease_)) return;
  machine_.note_foreign_lease();
  if (!machine_.is(GateState::latched))
    machine_.latch(phrase("two gates serve this robot: lease ", heard_lease_.lease_seq,
                          " of epoch ", Hex{heard_lease_.epoch}, ", which this one did not send"));
}

}  // namespace fairlead
