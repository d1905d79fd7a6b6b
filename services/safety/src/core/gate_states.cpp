// What the robot, the runners' heartbeats and the stop key say.

#include "gate_core.hpp"

namespace fairlead {

void Gate::Core::on_hal_status(Bytes frame) {
  if (decode(frame, hal_status_) != FrameFault::none) return count(code::frame);
  const HalLink::News news = hal_.take_status(hal_status_);
  if (news == HalLink::News::nothing) return;
  lease_due_ = status_due_ = true;
  if (news == HalLink::News::new_session) {
    log(phrase("following HAL session ", Hex{hal_.session()}));
    stops_.begin_session();
    good_states_ = 0;
    jump_memory_ = false;
  }
  if (!hal_.mismatch().empty()) log(hal_.mismatch());
  if (state_ != GateState::armed) return;
  // What was armed is not there any more, or is not what it was.
  disarm(news == HalLink::News::new_session ? Text("a new HAL session")
                                            : phrase("the HAL changed: ", hal_.mismatch()));
}

void Gate::Core::on_joint_state(Bytes frame) {
  if (decode(frame, joint_state_) != FrameFault::none) return count(code::frame);
  // G002 for states: another session's or another robot's say nothing about this one.
  if (joint_state_.session != hal_.session() || joint_state_.robot_hash != limits_.robot_hash)
    return count(code::session);
  if (joint_state_.tick == 0 || joint_state_.tick < hal_.tick()) return;  // overtaken on the way
  const Evidence evidence = check_state(limits_, joint_state_);
  if (!evidence.ok()) {
    good_states_ = 0;
    return raise_stop(evidence);
  }
  ++good_states_;
  lease_due_ = true;
  if (hal_.has_state() && joint_state_.tick == hal_.tick()) return;  // a repeat: the world waits
  on_new_tick(joint_state_);
}

void Gate::Core::on_new_tick(const JointState& message) {
  const MeasuredState before = hal_.state();
  hal_.take_state(message, now_ns_);
  if (state_ != GateState::armed) return;
  if (jump_memory_) {
    const Evidence evidence = check_jump(limits_, before, hal_.state());
    if (!evidence.ok()) return raise_stop(evidence);
  }
  jump_memory_ = true;
  for (LiveClaim& claim : claims_.places()) {
    if (claim.id == 0) continue;
    claim.plan.begin_tick(hal_.tick(), acted_of(claim));
    // The HAL did something else than expected: what is left is judged from where it is now.
    if (claim.plan.current() != nullptr && !claim.plan.on_track()) judge_again(claim);
  }
  for (LiveClaim& claim : claims_.places()) {
    if (claim.id == 0 || claim.waiting.empty()) continue;
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
  claim->heartbeat_ns = now_ns_;
}

void Gate::Core::on_stop_level(Bytes frame) {
  StopLevel level;
  if (decode(frame, level) == FrameFault::none && level.stop_id != 0)
    return hold_stop(level.stop_id, phrase("by ", level.by, ": ", level.reason));
  // Somebody wanted a stop. Without an id it gets one here, once.
  count(code::frame);
  if (stops_.held().empty()) hold_stop(new_id(), "an unreadable stop request");
}

}  // namespace fairlead
