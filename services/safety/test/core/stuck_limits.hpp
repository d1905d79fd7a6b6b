// Limits for tests of G041: numbers that binary fractions meet exactly.
#pragma once

#include "fairlead_safety/limits.hpp"

namespace fairlead::test {

inline constexpr double encoder_step = 0.0009765625;  // of the encoders, 2^-10

/// Three ticks of more than 1/64 [rad, m] without a change are too many.
inline void stick_soon(Limits& limits) {
  for (JointLimits& joint : limits.joints) {
    joint.encoder_step = encoder_step;
    joint.dead_band = 0.015625;
  }
  limits.protocol.stuck_ticks = 3;
}

}  // namespace fairlead::test
