// Queries: each gets exactly one reply or one refusal with the command that would fix it.

#include "core/gate/gate_core.hpp"
#include "core/modes/standstill.hpp"

namespace fairlead {
namespace {

// A latch is reset only when what caused it has been gone for this many states.
constexpr std::uint64_t good_states_to_reset = 10;
// A world that waits repeats its state every 100 ms.
constexpr std::uint64_t lockstep_silence_ms = 500;

}  // namespace

template <class Message>
void Gate::Core::reply(const Message& message) {
  out_->add(OutputKind::reply, Name(), message);
}

void Gate::Core::refuse_query(const Objection& objection) {
  log(phrase("refused a query: ", objection.reason));
  out_->add(OutputKind::refusal, Name(), Refusal{"safety", objection.reason, objection.fix});
}

template <class Message>
bool Gate::Core::read_query(Bytes frame, Message& message) {
  const FrameFault fault = decode(frame, message);
  if (fault == FrameFault::none) return true;
  count(code::frame);
  refuse_query({phrase("unreadable request: ", fault_name(fault)), {}});
  return false;
}

Objection Gate::Core::wrong_state(std::string_view wanted) const {
  constexpr std::array<std::string_view, 5> names{"starting", "disarmed", "armed", "stopped",
                                                  "latched"};
  return {phrase("the gate is ", names[static_cast<std::size_t>(state_)], ", not ", wanted, "; ",
                 cause_),
          fix()};
}

Objection Gate::Core::object_to_arming() const {
  if (state_ != GateState::disarmed) {
    Objection objection = wrong_state("disarmed");
    if (state_ == GateState::armed) objection.fix = "fairlead status";
    return objection;
  }
  if (const MemoryGuard* changed = find_changed())
    return {words_of(memory_fault(*changed)), "fairlead restart safety"};
  if (!status_fault_.empty()) return {status_fault_, "fairlead status"};
  if (!hal_.mismatch().empty()) return {hal_.mismatch(), "fairlead status"};
  if (hal_.two_at_once(now_ns_)) return {two_hals(), "fairlead ps"};
  if (hal_.resetting()) return {"the HAL is resetting its episode", "fairlead status"};
  if (!hal_.has_state()) return {"no valid joint state received yet", "fairlead status"};
  const std::uint64_t age_ms = (now_ns_ - hal_.arrival_ns()) / 1'000'000;
  if (!hal_.lockstep() && age_ms > limits_.protocol.state_timeout_ms)
    return {phrase("the newest joint state is ", age_ms, " ms old, at most ",
                   limits_.protocol.state_timeout_ms, " ms allowed"),
            "fairlead status"};
  return {};
}

Text Gate::Core::two_hals() const {
  return phrase("two HALs publish for this robot: sessions ", Hex{hal_.session()}, " and ",
                Hex{hal_.rival()});
}

void Gate::Core::on_arm(Bytes frame) {
  Arm request;
  if (!read_query(frame, request)) return;
  const Objection objection = object_to_arming();
  if (!objection.none()) return refuse_query(objection);
  // Leaving disarmed: should the process die from here on, it comes back latched.
  out_->add(OutputKind::clear_clean_mark);
  clean_mark_due_ = false;
  begin_epoch();
  armed_ns_ = now_ns_;
  jump_memory_ = false;
  overruns_ = {};
  begin_memories();
  stuck_watch_.clear();
  grasp_watch_.clear();
  claimless_since_ns_ = now_ns_;
  set_state(GateState::armed, phrase("armed by ", request.by));
  reply(ArmReply{epoch_, hal_.session()});
}

void Gate::Core::on_disarm(Bytes frame) {
  Disarm request;
  if (!read_query(frame, request)) return;
  if (state_ == GateState::stopped || state_ == GateState::latched)
    return refuse_query(wrong_state("armed"));
  if (state_ == GateState::armed) disarm(phrase("by ", request.by));
  reply(Done{"disarmed"});
}

Objection Gate::Core::object_to_latch_reset() const {
  if (!hal_.has_state())
    return {"no joint state received: standstill is not known", "fairlead status"};
  const std::uint64_t silent_ms = (now_ns_ - hal_.heard_ns()) / 1'000'000;
  const std::uint64_t limit_ms =
      hal_.lockstep() ? lockstep_silence_ms : limits_.protocol.state_timeout_ms;
  if (silent_ms > limit_ms)
    return {phrase("no joint state heard for ", silent_ms, " ms, at most ", limit_ms,
                   " ms allowed: standstill is not known"),
            "fairlead status"};
  if (!at_standstill(limits_, hal_.state())) return {"a joint is still moving", fix()};
  if (good_states_ < good_states_to_reset)
    return {phrase("only ", good_states_, " good joint states since the cause, ",
                   good_states_to_reset, " needed"),
            fix()};
  return {};
}

void Gate::Core::on_reset(Bytes frame) {
  Reset request;
  if (!read_query(frame, request)) return;
  const bool cites_latch = state_ == GateState::latched && request.id == latch_id_;
  if (cites_latch) {
    const Objection objection = object_to_latch_reset();
    if (!objection.none()) return refuse_query(objection);
    latch_id_ = 0;
    out_->add(OutputKind::clear_latch);
  } else if (!stops_.reset(request.id, now_ns_)) {
    // Forged, late or mistyped: nothing changes.
    ++resets_refused_;
    return refuse_query({phrase("no stop or latch ", Hex{request.id}, " is held"), fix()});
  }
  lease_due_ = status_due_ = true;
  if (latch_id_ == 0) {
    if (stops_.held().empty())
      become_disarmed(phrase("disarmed: ", Hex{request.id}, " was reset by ", request.by));
    else
      set_state(GateState::stopped, phrase("stopped: ", Hex{stops_.held()[0]}, " is still held"));
  }
  reply(Done{phrase(Hex{request.id}, " was reset")});
}

void Gate::Core::on_claim(Bytes frame) {
  if (!read_query(frame, claim_request_)) return;
  if (state_ != GateState::armed) return refuse_query(wrong_state("armed"));
  LiveClaim* place = claims_.free_place();
  if (place == nullptr)
    return refuse_query({phrase("all ", max_claims, " claims are taken"), "fairlead status"});
  const Objection objection = admit_claim(limits_, claims_, claim_request_, *place);
  if (!objection.none()) return refuse_query(objection);
  static_cast<ClaimLife&>(*place) = ClaimLife{};
  place->latest_verdict.verdict_id = 0;
  place->heartbeat_ns = now_ns_;
  place->guard = MemoryGuard(bytes_of(place->limits));
  place->id = new_id();
  log(phrase("claim ", Hex{place->id}, " of ", place->source, " for ", place->skill));
  lease_due_ = status_due_ = true;
  reply(ClaimReply{place->id, epoch_, hal_.session()});
}

void Gate::Core::on_release(Bytes frame) {
  Release request;
  if (!read_query(frame, request)) return;
  LiveClaim* claim = claims_.find(request.claim_id);
  if (claim == nullptr || !(claim->source == request.source))
    return refuse_query(
        {phrase(request.source, " holds no claim ", Hex{request.claim_id}), "fairlead status"});
  end_claim(*claim, "released");
  reply(Done{"released"});
}

void Gate::Core::on_status(Bytes frame) {
  StatusQuery request;
  if (read_query(frame, request)) publish_status(OutputKind::reply);
}

}  // namespace fairlead
