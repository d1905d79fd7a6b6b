#include "core/monitor/stop_monitor.hpp"

#include "core/chunk/state_check.hpp"

namespace fairlead {

void StopMonitor::begin_all(std::uint64_t now_ns) {
  for (RampWatch& ramp : ramps_) ramp.begin(now_ns, hal_.tick());
}

void StopMonitor::begin_of(const LiveClaim& claim, std::uint64_t now_ns) {
  for (const std::size_t part : claim.limits.parts)
    if (ramps_[part].moved()) ramps_[part].begin(now_ns, hal_.tick());
}

void StopMonitor::begin_session() {
  for (RampWatch& ramp : ramps_) ramp.begin_session();
}

// A part that stands still in a tick in which a row moved it may have just begun. A row without
// permission is no reason to wait longer: nor is one of a claim that has ended, whoever holds the
// part now.
void StopMonitor::see(const ClaimTable& claims, const PartHistory& history, bool is_armed,
                      std::uint64_t now_ns) {
  for (std::size_t i = 0; i < limits_.parts.size(); ++i) {
    RampWatch& ramp = ramps_[i];
    const Acted& act = hal_.state().acted[i];
    const bool acted = act.hold == 0;
    const LiveClaim* holder = claims.holder_of(i);
    if (is_armed && holder != nullptr && holder->plan.row_of(act).chunk != nullptr) {
      ramp.move();
      continue;
    }
    if (acted || ramp.moved() || history.may_have_acted(i, hal_.tick()))
      ramp.begin(now_ns, hal_.tick());
    if (ramp.active())
      ramp.see(hal_.tick(), !acted && part_at_standstill(limits_, hal_.state(), limits_.parts[i]));
  }
}

// Time is the gate's own clock in realtime, also where no state comes any more: unknown is not
// standstill. In lockstep it is the ticks of the states: without one the world stands.
Evidence StopMonitor::find_unstopped(std::uint64_t now_ns) {
  Evidence evidence;
  for (std::size_t i = 0; i < limits_.parts.size(); ++i) {
    const RampWatch& ramp = ramps_[i];
    unstopped_[i] = false;
    if (!ramp.active()) continue;
    const std::uint64_t passed_ns =
        hal_.lockstep() ? ramp.ticks_since() * limits_.period_ns : ramp.ns_since(now_ns);
    unstopped_[i] = passed_ns > limits_.protocol.stop_ramp_ms * 1'000'000ULL;
    if (unstopped_[i] && evidence.ok()) evidence = why_unstopped(i, now_ns);
  }
  return evidence;
}

void StopMonitor::end_unstopped() {
  for (std::size_t i = 0; i < unstopped_.size(); ++i)
    if (unstopped_[i]) ramps_[i].end();
}

Evidence StopMonitor::why_unstopped(std::size_t index, std::uint64_t now_ns) const {
  const PartLimits& part = limits_.parts[index];
  if (!ramps_[index].seen())
    return declared_as(above(code::ramp, "state age",
                             static_cast<double>((now_ns - hal_.arrival_ns()) / 1'000'000),
                             limits_.protocol.stop_ramp_ms, "ms", "no state since then"),
                       "no state since then");
  const MeasuredState& state = hal_.state();
  const Evidence moving = check_still(code::ramp, limits_, state, part);
  if (!moving.ok()) return of(moving, part.name);
  if (state.acted[index].hold == 0)
    return of(broken_rule(code::ramp, "acted", "no row that acts"), part.name);
  return of(below(code::ramp, "still states", ramps_[index].still(), RampWatch::still_states, "1",
                  "states at standstill in a row"),
            part.name);
}

}  // namespace fairlead
