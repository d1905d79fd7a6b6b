// G050: the gate's own time, and the limits in its own memory.

#include "gate_core.hpp"

namespace fairlead {
namespace {

constexpr std::size_t overruns_to_stop = 3;
constexpr std::uint64_t overrun_window_ns = 60'000'000'000;

}  // namespace

void Gate::Core::check_own(std::uint32_t previous_step_ns) {
  check_step_time(previous_step_ns);
  check_memory();
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

void Gate::Core::check_memory() {
  if (!guard_.read_on(now_ns_) || guard_.intact()) return;
  if (state_ == GateState::armed) return raise_stop(memory_fault());
  count(code::own);
  log(words_of(memory_fault()));
}

Evidence Gate::Core::memory_fault() const {
  return broken_rule(code::own, "limits in memory", "the CRC-32 of the limits that were loaded",
                     guard_.found(), guard_.expected());
}

}  // namespace fairlead
