// G050: the gate's own time, and the limits in its own memory.

#include "core/gate/gate_core.hpp"

namespace fairlead {
namespace {

constexpr std::size_t overruns_to_stop = 3;
constexpr std::uint64_t overrun_window_ns = 60'000'000'000;

}  // namespace

// A chunk does not wait for memory to be read: the timer's next step does that, 5 ms later unless
// more chunks than the gate can judge keep it busy, and then as soon as it gets its turn.
void Gate::Core::check_own(const Event& event) {
  check_step_time(event.previous_step_ns);
  if (event.kind != EventKind::candidate) check_memory();
}

// In lockstep the world waits for the gate, however long a step takes.
void Gate::Core::check_step_time(std::uint32_t previous_step_ns) {
  if (state_ != GateState::armed || hal_.lockstep()) return;
  const std::uint32_t limit_us = limits_.protocol.step_deadline_us;
  if (previous_step_ns <= limit_us * 1000ULL) return;
  overruns_.add(now_ns_);
  const std::size_t recent = overruns_.count(now_ns_, overrun_window_ns);
  const Evidence evidence = above(code::own, "step [us]", previous_step_ns * 1e-3, limit_us,
                                  "protocol step_deadline_us, three times in 60 s");
  if (recent >= overruns_to_stop) return raise_stop(evidence);
  count(code::own);
  log(phrase(words_of(evidence), ": ", recent, " so far"));
}

// The next slice of everything that is guarded. True when a whole pass of something has ended.
bool Gate::Core::read_memory() {
  bool passed = guard_.read_on(now_ns_);
  passed |= plan_guard_.read_on(now_ns_);
  for (LiveClaim& claim : claims_.places())
    if (claim.live()) passed |= claim.guard.read_on(now_ns_);
  return passed;
}

// The first whose newest whole pass found other bytes, nullptr if none did.
const MemoryGuard* Gate::Core::find_changed() const {
  if (!guard_.intact()) return &guard_;
  if (!plan_guard_.intact()) return &plan_guard_;
  for (const LiveClaim& claim : claims_.places())
    if (claim.live() && !claim.guard.intact()) return &claim.guard;
  return nullptr;
}

void Gate::Core::check_memory() {
  if (!read_memory()) return;
  const MemoryGuard* changed = find_changed();
  if (changed == nullptr) return;
  if (state_ == GateState::armed) return raise_stop(memory_fault(*changed));
  count(code::own);
  log(words_of(memory_fault(*changed)));
}

Evidence Gate::Core::memory_fault(const MemoryGuard& guard) {
  return broken_rule(code::own, "limits in memory", "the CRC-32 of the limits that were loaded",
                     guard.found(), guard.expected());
}

}  // namespace fairlead
