// One step: deadlines first, then the event, then what has to be published.

#include "fairlead_safety/gate.hpp"

#include <type_traits>

#include "core/gate/gate_core.hpp"

namespace fairlead {

Gate::Gate(const Limits& limits, IdSource& ids) : core_(std::make_unique<Core>(limits, ids)) {}
Gate::~Gate() = default;
void Gate::boot(std::uint64_t now_ns, const BootInfo& info, Outputs& outputs) {
  core_->boot(now_ns, info, outputs);
}
void Gate::step(std::uint64_t now_ns, const Event& event, Outputs& outputs) {
  core_->step(now_ns, event, outputs);
}
GateState Gate::state() const { return core_->state(); }

// A guard reads bytes: nothing guarded may point to more of itself. (A plan's matrices are of fixed
// size, in place, though Eigen does not call them trivial.)
static_assert(std::is_trivially_copyable_v<Limits> && std::is_trivially_copyable_v<ClaimLimits>);

Gate::Core::Core(const Limits& limits, IdSource& ids)
    : limits_(limits),
      guard_(bytes_of(limits_)),
      path_plan_(limits_),
      plan_guard_(bytes_of(path_plan_)),
      ids_(ids),
      hal_(limits_) {
  begin_epoch();
  // Half the range is left to count upwards in.
  next_verdict_ = (new_id() >> 1U) + 1;
}

std::uint64_t Gate::Core::new_id() {
  std::uint64_t id = 0;
  while (id == 0) id = ids_.next_id();
  return id;
}

void Gate::Core::begin_epoch() {
  epoch_ = new_id();
  leases_.begin_epoch(epoch_);
}

void Gate::Core::count(std::uint32_t code) { ++code_counts_[code]; }

void Gate::Core::step(std::uint64_t now_ns, const Event& event, Outputs& outputs) {
  outputs.clear();
  out_ = &outputs;
  now_ns_ = now_ns;
  if (state_ == GateState::boot) {  // before boot(): status only
    if (event.kind == EventKind::status) on_status(event.payload);
    return;
  }
  check_own(event);
  check_deadlines();
  handle(event);
  finish();
}

void Gate::Core::handle(const Event& event) {
  switch (event.kind) {
    case EventKind::timer:
      return;
    case EventKind::joint_state:
      return on_joint_state(event);
    case EventKind::candidate:
      return on_candidate(event);
    case EventKind::hal_status:
      return on_hal_status(event.payload);
    case EventKind::heartbeat:
      return on_heartbeat(event);
    case EventKind::stop_level:
      return on_stop_level(event.payload);
    case EventKind::arm:
      return on_arm(event.payload);
    case EventKind::disarm:
      return on_disarm(event.payload);
    case EventKind::reset:
      return on_reset(event.payload);
    case EventKind::claim:
      return on_claim(event.payload);
    case EventKind::release:
      return on_release(event.payload);
    case EventKind::status:
      return on_status(event.payload);
    case EventKind::lease:
      return on_lease(event.payload);
  }
}

// Everything that depends on the gate's own clock. Time is judged before the event is looked
// at, so that a process that slept does not act on what it slept through.
void Gate::Core::check_deadlines() {
  if (!hal_.lockstep()) check_ramps();
  if (state_ != GateState::armed) return;
  constexpr std::uint64_t ms = 1'000'000;
  const ProtocolLimits& protocol = limits_.protocol;
  // G011: no new state for too long. In lockstep the world may wait for as long as it likes.
  if (!hal_.lockstep() && now_ns_ - hal_.arrival_ns() > protocol.state_timeout_ms * ms)
    return raise_stop(above(code::state, "state age [ms]",
                            static_cast<double>((now_ns_ - hal_.arrival_ns()) / ms),
                            protocol.state_timeout_ms, "protocol state_timeout_ms"));
  const std::uint64_t silence_ms = hal_.lockstep() ? protocol.heartbeat_timeout_lockstep_ms
                                                   : protocol.heartbeat_timeout_realtime_ms;
  for (LiveClaim& claim : claims_.places())
    if (claim.live() && now_ns_ - claim.heartbeat_ns > silence_ms * ms)
      end_claim(claim, "its heartbeat was lost");
  if (!claims_.empty()) claimless_since_ns_ = now_ns_;
  if (now_ns_ - claimless_since_ns_ > protocol.idle_disarm_s * 1000 * ms)
    disarm(phrase("no claim for ", protocol.idle_disarm_s, " s"));
}

}  // namespace fairlead
