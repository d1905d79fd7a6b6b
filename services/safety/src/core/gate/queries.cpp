#include "core/gate/queries.hpp"

#include "core/chunk/state_check.hpp"

namespace fairlead {
namespace {

// A latch is reset only when what caused it has been gone for this many states.
constexpr std::uint64_t good_states_to_reset = 10;
// A world that waits repeats its state every 100 ms.
constexpr std::uint64_t lockstep_silence_ms = 500;

}  // namespace

template <class Message>
void Queries::reply(const Message& message) {
  outbox_.out->add(OutputKind::reply, Name(), message);
}

void Queries::refuse_query(const Objection& objection) {
  outbox_.log(phrase("refused a query: ", objection.reason));
  outbox_.out->add(OutputKind::refusal, Name(), Refusal{"safety", objection.reason, objection.fix});
}

template <class Message>
bool Queries::read_query(Bytes frame, Message& message) {
  const FrameFault fault = decode(frame, message);
  if (fault == FrameFault::none) return true;
  outbox_.count(code::frame);
  refuse_query({phrase("unreadable request: ", fault_name(fault)), {}});
  return false;
}

Objection Queries::wrong_state(std::string_view wanted) const {
  constexpr std::array<std::string_view, 5> names{"starting", "disarmed", "armed", "stopped",
                                                  "latched"};
  return {phrase("the gate is ", names[static_cast<std::size_t>(machine_.state())], ", not ",
                 wanted, "; ", machine_.cause()),
          machine_.fix()};
}

Objection Queries::object_to_arming() const {
  if (!machine_.is(GateState::disarmed)) {
    Objection objection = wrong_state("disarmed");
    if (machine_.is_armed()) objection.fix = "fairlead status";
    return objection;
  }
  if (const Evidence changed = self_.find_changed(claims_); !changed.ok())
    return {words_of(changed), "fairlead restart safety"};
  if (!robot_.status_fault().empty()) return {robot_.status_fault(), "fairlead status"};
  if (!hal_.mismatch().empty()) return {hal_.mismatch(), "fairlead status"};
  if (hal_.two_at_once(outbox_.now_ns)) return {two_hals(hal_), "fairlead ps"};
  if (hal_.resetting()) return {"the HAL is resetting its episode", "fairlead status"};
  if (!hal_.has_state()) return {"no valid joint state received yet", "fairlead status"};
  const std::uint64_t age_ms = (outbox_.now_ns - hal_.arrival_ns()) / 1'000'000;
  if (!hal_.lockstep() && age_ms > limits_.protocol.state_timeout_ms)
    return {phrase("the newest joint state is ", age_ms, " ms old, at most ",
                   limits_.protocol.state_timeout_ms, " ms allowed"),
            "fairlead status"};
  return {};
}

void Queries::on_arm(Bytes frame) {
  Arm request;
  if (!read_query(frame, request)) return;
  const Objection objection = object_to_arming();
  if (!objection.none()) return refuse_query(objection);
  self_.begin();
  motion_.begin();
  history_.begin(hal_.state());
  machine_.arm(phrase("armed by ", request.by));
  reply(ArmReply{machine_.epoch(), hal_.session()});
}

void Queries::on_disarm(Bytes frame) {
  Disarm request;
  if (!read_query(frame, request)) return;
  if (machine_.is(GateState::stopped) || machine_.is(GateState::latched))
    return refuse_query(wrong_state("armed"));
  if (machine_.is_armed()) machine_.disarm(phrase("by ", request.by));
  reply(Done{"disarmed"});
}

Objection Queries::object_to_latch_reset() const {
  if (!hal_.has_state())
    return {"no joint state received: standstill is not known", "fairlead status"};
  const std::uint64_t silent_ms = (outbox_.now_ns - hal_.heard_ns()) / 1'000'000;
  const std::uint64_t limit_ms =
      hal_.lockstep() ? lockstep_silence_ms : limits_.protocol.state_timeout_ms;
  if (silent_ms > limit_ms)
    return {phrase("no joint state heard for ", silent_ms, " ms, at most ", limit_ms,
                   " ms allowed: standstill is not known"),
            "fairlead status"};
  if (!at_standstill(limits_, hal_.state())) return {"a joint is still moving", machine_.fix()};
  if (machine_.good_states() < good_states_to_reset)
    return {phrase("only ", machine_.good_states(), " good joint states since the cause, ",
                   good_states_to_reset, " needed"),
            machine_.fix()};
  return {};
}

// Where the profile asks for two, the first is told so, and the latch stays.
Objection Queries::object_to_one_person(const Reset& request) {
  const std::uint32_t window_s = limits_.protocol.second_person_s;
  if (window_s == 0) return {};
  const std::string_view first = person_of(first_reset_.by);
  const std::string_view person = person_of(request.by);
  const bool in_time = outbox_.now_ns - first_reset_ns_ <= window_s * 1'000'000'000ULL;
  const bool is_second = first_reset_.id == request.id && in_time && !first.empty() &&
                         !person.empty() && first != person;
  if (is_second) return {};
  first_reset_ = request;
  first_reset_ns_ = outbox_.now_ns;
  return {phrase(request.by, " asked to reset the latch; another person has to ask too, within ",
                 window_s, " s"),
          machine_.fix()};
}

void Queries::on_reset(Bytes frame) {
  Reset request;
  if (!read_query(frame, request)) return;
  if (machine_.is(GateState::latched) && request.id == machine_.latch_id()) {
    Objection objection = object_to_latch_reset();
    if (objection.none()) objection = object_to_one_person(request);
    if (!objection.none()) return refuse_query(objection);
    machine_.clear_latch();
    if (limits_.protocol.second_person_s != 0)
      request.by = phrase(first_reset_.by, " and ", request.by);
  } else if (!machine_.reset_stop(request.id)) {
    // Forged, late or mistyped: nothing changes.
    ++outbox_.counters.resets_refused;
    return refuse_query({phrase("no stop or latch ", Hex{request.id}, " is held"), machine_.fix()});
  }
  machine_.leave_stops(request.id, request.by.view());
  reply(Done{phrase(Hex{request.id}, " was reset")});
}

void Queries::on_claim(Bytes frame) {
  claim_request_.by.clear();  // may be left out
  if (!read_query(frame, claim_request_)) return;
  if (!machine_.is_armed()) return refuse_query(wrong_state("armed"));
  LiveClaim* place = claims_.free_place();
  if (place == nullptr)
    return refuse_query({phrase("all ", max_claims, " claims are taken"), "fairlead status"});
  const Objection objection = admit_claim(limits_, claims_, claim_request_, *place);
  if (!objection.none()) return refuse_query(objection);
  LiveClaim* claim = take_offered(*place);
  if (claim == nullptr) {
    claim = place;
    static_cast<ClaimLife&>(*claim) = ClaimLife{};
    claim->latest_verdict.verdict_id = 0;
    claim->id = machine_.new_id();
  }
  claim->heartbeat_ns = outbox_.now_ns;
  claim->guard = MemoryGuard(bytes_of(claim->limits));
  const Text& by = claim_request_.by;
  outbox_.log(phrase("claim ", Hex{claim->id}, " of ", claim->source, " for ", claim->skill,
                     by.empty() ? "" : ", by ", by));
  outbox_.announce();
  reply(ClaimReply{claim->id, machine_.epoch(), hal_.session()});
}

// What was offered of other parts ends: it was released but for this.
LiveClaim* Queries::take_offered(const LiveClaim& next) {
  for (LiveClaim& holder : claims_.places()) {
    if (!holder.live() || !holder.shares_parts_with(next)) continue;
    if (holder.has_parts_of(next)) {
      outbox_.log(phrase("claim ", Hex{holder.id}, " of ", holder.source, " is handed over"));
      holder.continue_as(next);
      return &holder;
    }
    machine_.end_claim(holder, "released");
  }
  return nullptr;
}

void Queries::on_release(Bytes frame) {
  Release request;
  if (!read_query(frame, request)) return;
  LiveClaim* claim = claims_.find(request.claim_id);
  if (claim == nullptr || !(claim->source == request.source))
    return refuse_query(
        {phrase(request.source, " holds no claim ", Hex{request.claim_id}), "fairlead status"});
  if (!request.offered_to.empty()) {
    claim->offered_to = request.offered_to;
    outbox_.log(phrase("claim ", Hex{claim->id}, " is offered to ", claim->offered_to));
    return reply(Done{"offered"});
  }
  machine_.end_claim(*claim, "released");
  reply(Done{"released"});
}

void Queries::on_status(Bytes frame) {
  StatusQuery request;
  if (read_query(frame, request)) publisher_.publish_status(OutputKind::reply);
}

}  // namespace fairlead
