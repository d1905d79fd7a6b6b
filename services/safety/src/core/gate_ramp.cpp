// G043: after a stop, standstill within the declared ramp; what does not stop latches.

#include <cmath>

#include "gate_core.hpp"

namespace fairlead {

void Gate::Core::begin_ramp() {
  if (state_ == GateState::armed) ramp_.begin(now_ns_, hal_.tick());
}

// A part that stands still in a tick in which a row moved it may have just begun.
void Gate::Core::watch_ramp() {
  if (!ramp_.active()) return;
  bool acted = false;
  bool still = true;
  for (std::size_t i = 0; i < limits_.parts.size(); ++i) {
    acted |= hal_.state().acted[i].hold == 0;
    still &= part_at_standstill(limits_, hal_.state(), limits_.parts[i]);
  }
  ramp_.see(hal_.tick(), acted, still && !acted);
  check_ramp();
}

// Time is the gate's own clock in realtime, also where no state comes any more: unknown is not
// standstill. In lockstep it is the ticks of the states: without one the world stands.
void Gate::Core::check_ramp() {
  if (!ramp_.active()) return;
  const std::uint64_t passed_ns =
      hal_.lockstep() ? ramp_.ticks_since() * limits_.period_ns : ramp_.ns_since(now_ns_);
  if (passed_ns <= limits_.protocol.stop_ramp_ms * 1'000'000ULL) return;
  ramp_.end();
  if (!ramp_.still()) latch_unstopped(find_unstopped());
}

// Which joint, part or silence it is.
Evidence Gate::Core::find_unstopped() const {
  if (!ramp_.seen())
    return above(code::ramp, "state age [ms]",
                 static_cast<double>((now_ns_ - hal_.arrival_ns()) / 1'000'000),
                 limits_.protocol.stop_ramp_ms, "no state since the stop");
  const MeasuredState& state = hal_.state();
  for (const PartLimits& part : limits_.parts)
    for (const std::size_t j : part.joints) {
      const JointLimits& joint = limits_.joints[j];
      const double speed = std::abs(state.velocities[j]);
      if (!(speed < joint.standstill_velocity))
        return at(above(code::ramp, joint.name.view(), speed, joint.standstill_velocity,
                        joint.source.view()),
                  -1, part.name);
    }
  return broken_rule(code::ramp, "acted", "no row acts any more");
}

void Gate::Core::latch_unstopped(const Evidence& evidence) {
  count(code::ramp);
  const Text cause = phrase("no standstill ", limits_.protocol.stop_ramp_ms,
                            " ms after the stop: ", words_of(evidence));
  if (state_ != GateState::latched) return latch(cause);
  // Latched already: the cause grows, and goes to the disk once more.
  set_state(GateState::latched, phrase(cause_, "; ", cause));
  good_states_ = 0;
  persist_latch_due_ = true;
}

}  // namespace fairlead
