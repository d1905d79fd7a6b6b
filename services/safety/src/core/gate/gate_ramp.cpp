// G043: after the end of permission, standstill within the declared ramp; what does not stop
// latches.

#include "core/gate/gate_core.hpp"
#include "core/modes/standstill.hpp"

namespace fairlead {

// After a stop every part has to be seen at standstill, whoever moved it.
void Gate::Core::begin_ramps() {
  if (state_ != GateState::armed) return;
  for (RampWatch& ramp : ramps_) ramp.begin(now_ns_, hal_.tick());
}

// A claim that ends leaves its parts to their hold law.
void Gate::Core::begin_ramps_of(const LiveClaim& claim) {
  for (const std::size_t part : claim.limits.parts)
    if (ramps_[part].moved()) ramps_[part].begin(now_ns_, hal_.tick());
}

// A part that stands still in a tick in which a row moved it may have just begun. A row without
// permission is no reason to wait longer: nor is one of a claim that has ended, whoever holds the
// part now.
void Gate::Core::watch_ramps() {
  for (std::size_t i = 0; i < limits_.parts.size(); ++i) {
    RampWatch& ramp = ramps_[i];
    const Acted& act = hal_.state().acted[i];
    const bool acted = act.hold == 0;
    const LiveClaim* holder = claims_.holder_of(i);
    if (state_ == GateState::armed && holder != nullptr &&
        holder->plan.row_of(act).chunk != nullptr) {
      ramp.move();
      continue;
    }
    if (acted || ramp.moved() || may_have_acted(i)) ramp.begin(now_ns_, hal_.tick());
    if (ramp.active())
      ramp.see(hal_.tick(), !acted && part_at_standstill(limits_, hal_.state(), limits_.parts[i]));
  }
  check_ramps();
}

// Time is the gate's own clock in realtime, also where no state comes any more: unknown is not
// standstill. In lockstep it is the ticks of the states: without one the world stands.
void Gate::Core::check_ramps() {
  Evidence evidence;
  std::array<bool, max_parts> unstopped{};
  for (std::size_t i = 0; i < limits_.parts.size(); ++i) {
    const RampWatch& ramp = ramps_[i];
    if (!ramp.active()) continue;
    const std::uint64_t passed_ns =
        hal_.lockstep() ? ramp.ticks_since() * limits_.period_ns : ramp.ns_since(now_ns_);
    unstopped[i] = passed_ns > limits_.protocol.stop_ramp_ms * 1'000'000ULL;
    if (unstopped[i] && evidence.ok()) evidence = find_unstopped(i);
  }
  if (evidence.ok()) return;
  latch_unstopped(evidence);
  for (std::size_t i = 0; i < unstopped.size(); ++i)  // said once
    if (unstopped[i]) ramps_[i].end();
}

// Which joint or silence it is.
Evidence Gate::Core::find_unstopped(std::size_t index) const {
  const PartLimits& part = limits_.parts[index];
  if (!ramps_[index].seen())
    return above(code::ramp, "state age [ms]",
                 static_cast<double>((now_ns_ - hal_.arrival_ns()) / 1'000'000),
                 limits_.protocol.stop_ramp_ms, "no state since then");
  const MeasuredState& state = hal_.state();
  const Evidence moving = check_still(code::ramp, limits_, state, part);
  if (!moving.ok()) return of(moving, part.name);
  if (state.acted[index].hold == 0)
    return of(broken_rule(code::ramp, "acted", "no row acts any more"), part.name);
  return of(below(code::ramp, "still states", ramps_[index].still(), RampWatch::still_states,
                  "states at standstill in a row"),
            part.name);
}

void Gate::Core::latch_unstopped(const Evidence& evidence) {
  count(code::ramp);
  const bool told = state_ == GateState::stopped || state_ == GateState::latched;
  const Text cause = phrase("no standstill ", limits_.protocol.stop_ramp_ms, " ms after the ",
                            told ? "stop: " : "end of its rows: ", words_of(evidence));
  if (state_ != GateState::latched) return latch(cause);
  // Latched already: the cause grows, and goes to the disk once more.
  set_state(GateState::latched, phrase(cause_, "; ", cause));
  good_states_ = 0;
  persist_latch_due_ = true;
}

}  // namespace fairlead
