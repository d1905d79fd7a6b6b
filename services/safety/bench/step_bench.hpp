// A whole step of the gate, from received to encoded bytes, as one robot's ticks drive it.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "fairlead_safety/gate.hpp"

namespace fairlead::bench {

/// One step: by the clock, and of the processor's time alone, which leaves out what the machine
/// gave to others meanwhile [ns].
struct StepTime {
  double wall_ns = 0.0;
  double busy_ns = 0.0;
};

struct StepTimes {
  std::vector<StepTime> chunks;  // a candidate of so many rows: decode, judge, encode
  std::vector<StepTime> states;  // the next joint state, which judges released rows again
  std::string refused;           // why, if a chunk was refused or cut: then the times mean nothing
};

/// Arms a gate for `limits` and gives it `ticks` states, after each a chunk of `rows` rows for
/// every part. The robot stands still and every part holds, so each tick begins as the one before.
StepTimes time_steps(const Limits& limits, bool lockstep, std::uint32_t rows, std::size_t ticks);

}  // namespace fairlead::bench
