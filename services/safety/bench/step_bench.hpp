// A whole step of the gate, from received to encoded bytes, as one robot's ticks drive it.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "bench_gate.hpp"

namespace fairlead::bench {

struct StepTimes {
  std::vector<StepTime> chunks;  // a candidate of so many rows: decode, judge, encode
  std::vector<StepTime> states;  // the next joint state, which judges released rows again
  std::string refused;           // why, if a chunk was refused or cut: then the times mean nothing
};

struct StepKind {
  bool lockstep = false;
  bool moving = false;  // chunks that oscillate, else chunks that hold
  std::uint32_t rows = 0;
};

/// Arms a gate for `limits` and gives it `ticks` states, after each a chunk of rows for every part.
/// Rows that oscillate do not before the third: the next chunk replaces them before any of them
/// acts, and the robot stands still, so each tick begins as the one before.
StepTimes time_steps(const Limits& limits, StepKind kind, std::size_t ticks);

}  // namespace fairlead::bench
