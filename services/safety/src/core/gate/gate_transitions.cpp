// The state machine: boot -> disarmed -> armed, and from any of them to stopped or latched.

#include "core/gate/gate_core.hpp"

namespace fairlead {
namespace {

// How long copies of a reset stop may be under way after arming.
constexpr std::uint64_t copies_end_ns = 2'000'000'000;

}  // namespace

void Gate::Core::set_state(GateState state, const Text& cause) {
  state_ = state;
  cause_ = cause;
  lease_due_ = status_due_ = true;
  log(cause);
}

void Gate::Core::boot(std::uint64_t now_ns, const BootInfo& info, Outputs& outputs) {
  outputs.clear();
  out_ = &outputs;
  now_ns_ = now_ns;
  LatchRecord record;
  if (!info.latch.empty()) {
    const bool readable = decode(info.latch, record) == FrameFault::none && record.latch_id != 0;
    // Unreadable is no reason to forget it.
    latch_id_ = readable ? record.latch_id : new_id();
    set_state(GateState::latched, phrase("latched before the restart: ",
                                         readable ? record.cause.view() : "unreadable"));
    persist_latch_due_ = !readable;
  } else if (info.first_start && !limits_.lockstep_allowed && !info.new_state) {
    // A state folder that went missing must not turn a latched robot into a clean one.
    latch("the state folder was never used before; start with --new-state if that is right");
  } else if (!info.first_start && !info.clean_mark) {
    latch("the last exit was not clean: armed, stopped or latched");
  } else {
    become_disarmed("started");
  }
  finish();
}

void Gate::Core::become_disarmed(const Text& cause) {
  set_state(GateState::disarmed, cause);
  clean_mark_due_ = true;
}

void Gate::Core::disarm(const Text& cause) {
  end_claims("the gate was disarmed");
  become_disarmed(phrase("disarmed: ", cause));
}

Text Gate::Core::words_of(const Evidence& evidence) {
  const auto gap = [](std::string_view word) { return word.empty() ? "" : " "; };
  Text text = phrase(code_name(evidence.code), gap(evidence.part), evidence.part,
                     gap(evidence.axis), evidence.axis, ": ",
                     Beside{evidence.value, evidence.limit}, gap(evidence.unit), evidence.unit);
  text = phrase(text, ", limit ", Beside{evidence.limit, evidence.value}, gap(evidence.unit),
                evidence.unit, " (", evidence.key, evidence.key.empty() ? "" : ": ",
                evidence.limit_source, ")");
  return text;
}

// A stop that the gate itself decided on. Too many within the window are no coincidence: latch.
void Gate::Core::raise_stop(const Evidence& evidence) {
  if (state_ != GateState::armed) return;
  count(evidence.code);
  const Text cause = words_of(evidence);
  const std::uint64_t window =
      limits_.protocol.stop_window_s * 1'000'000'000ULL / limits_.period_ns;
  if (stops_.note_raised(hal_.tick(), window) >= limits_.protocol.stops_to_latch)
    return latch(phrase(limits_.protocol.stops_to_latch, " stops in ",
                        limits_.protocol.stop_window_s, " s, the last: ", cause));
  hold_stop(new_id(), cause);
}

void Gate::Core::hold_stop(std::uint64_t id, const Text& cause) {
  if (stops_.is_late_copy(id, now_ns_)) {
    // Whoever raised it lets go when a new epoch is armed: copies that go on are a new stop.
    const bool goes_on = state_ == GateState::armed && now_ns_ - armed_ns_ > copies_end_ns;
    if (!goes_on) return ignore_copy(id);
    stops_.forget(id);
  }
  if (stops_.hold(id)) lease_due_ = status_due_ = true;
  if (state_ != GateState::disarmed && state_ != GateState::armed) return;  // severity only rises
  if (state_ == GateState::disarmed) out_->add(OutputKind::clear_clean_mark);
  clean_mark_due_ = false;
  begin_ramps();
  end_claims("the gate was stopped");
  set_state(GateState::stopped, phrase("stopped: ", cause));
}

// Counted every time; said once a second, since whoever repeats it does so every 50 ms.
void Gate::Core::ignore_copy(std::uint64_t id) {
  ++stops_ignored_;
  if (now_ns_ - ignored_ns_ < 1'000'000'000) return;
  ignored_ns_ = now_ns_;
  log(phrase("ignored a copy of stop ", Hex{id}, ", which was reset (", stops_ignored_,
             " ignored so far)"));
}

void Gate::Core::latch(const Text& cause) {
  if (state_ == GateState::disarmed) out_->add(OutputKind::clear_clean_mark);
  clean_mark_due_ = false;
  begin_ramps();
  end_claims("the gate latched");
  latch_id_ = new_id();
  good_states_ = 0;
  persist_latch_due_ = true;
  set_state(GateState::latched, phrase("latched: ", cause));
}

void Gate::Core::end_claim(LiveClaim& claim, std::string_view reason) {
  log(phrase("claim ", Hex{claim.id}, " of ", claim.source, " ended: ", reason));
  keep_memories(claim);
  begin_ramps_of(claim);
  claim.id = 0;
  claim.plan.clear();
  claim.waiting.clear();
  claimless_since_ns_ = now_ns_;
  lease_due_ = status_due_ = true;
}

void Gate::Core::end_claims(std::string_view reason) {
  for (LiveClaim& claim : claims_.places())
    if (claim.live()) end_claim(claim, reason);
}

}  // namespace fairlead
