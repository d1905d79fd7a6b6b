// How long the gate's slowest step is, as far as a search finds it.
#pragma once

#include <cstdint>
#include <string>

#include "fairlead_safety/limits.hpp"

namespace fairlead::bench {

/// Processor's time of steps that an attack takes [us], the longest of each kind, all claims'
/// chunks sent in one tick.
struct AttackedSteps {
  double chunk_us = 0.0;  // a candidate
  double state_us = 0.0;  // a new state, which judges what is released again
  double tick_us = 0.0;   // everything between two states

  [[nodiscard]] double longest_us() const { return chunk_us > state_us ? chunk_us : state_us; }
};

struct WorstStep {
  std::size_t most_configurations = 0;  // of one judgement, of all that were tried
  double most_configurations_us = 0.0;  // that judgement alone
  AttackedSteps steps;                  // of the slowest attack; its quickest repetition
  std::size_t attacks = 0;              // that were tried
};

/// Varies where the robot stands and what every part is told there, and keeps what takes longer,
/// for so much of the processor's time: half of it a judgement that looks most, then a step that
/// takes longest, each part with a claim of its own. Realtime; chunks of as many rows as are
/// allowed.
WorstStep find_worst_step(const Limits& limits, double seconds);

}  // namespace fairlead::bench
