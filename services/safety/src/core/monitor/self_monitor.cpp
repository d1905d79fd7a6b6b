#include "core/monitor/self_monitor.hpp"

#include <type_traits>

namespace fairlead {
namespace {

constexpr std::uint64_t overrun_window_ns = 60'000'000'000;

// A guard reads bytes: nothing guarded may point to more of itself. (A model's matrices are of
// fixed size, in place, though Eigen does not call them trivial.)
static_assert(std::is_trivially_copyable_v<Limits> && std::is_trivially_copyable_v<ClaimLimits>);

Evidence memory_fault(const MemoryGuard& guard) {
  return broken_rule(code::own, "limits in memory", "the limits as they were loaded", guard.found(),
                     guard.expected());
}

}  // namespace

SelfMonitor::SelfMonitor(const Limits& limits, const RobotModel& model)
    : limits_(bytes_of(limits)), model_(bytes_of(model)) {}

Evidence check_step_time(const Limits& limits, std::uint32_t step_ns) {
  const std::uint32_t limit_us = limits.protocol.step_deadline_us;
  if (step_ns <= limit_us * 1000ULL) return {};
  return declared_as(above(code::own, "step", step_ns * 1e-3, limit_us, "us",
                           "protocol step_deadline_us, three times in 60 s"),
                     "step_deadline_us, three times in 60 s");
}

std::size_t SelfMonitor::note_overrun(std::uint64_t now_ns) {
  overruns_.add(now_ns);
  return overruns_.count(now_ns, overrun_window_ns);
}

bool SelfMonitor::read_on(std::uint64_t now_ns, ClaimTable& claims) {
  bool passed = limits_.read_on(now_ns);
  passed |= model_.read_on(now_ns);
  for (LiveClaim& claim : claims.places())
    if (claim.live()) passed |= claim.guard.read_on(now_ns);
  return passed;
}

Evidence SelfMonitor::find_changed(const ClaimTable& claims) const {
  if (!limits_.intact()) return memory_fault(limits_);
  if (!model_.intact()) return memory_fault(model_);
  for (const LiveClaim& claim : claims.places())
    if (claim.live() && !claim.guard.intact()) return memory_fault(claim.guard);
  return {};
}

}  // namespace fairlead
