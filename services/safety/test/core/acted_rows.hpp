// What a HAL that was told something says it did.
#pragma once

#include "gate_rig.hpp"

namespace fairlead::test {

inline Acted row_of(const SafeChunk& safe, std::uint32_t row) {
  return Acted{0, safe.verdict_id, row};
}

inline std::uint8_t decision(const GateRig& rig) { return rig.lease().grants[0].decision; }

inline constexpr auto number = [](Decision value) { return static_cast<std::uint8_t>(value); };

// A HAL that does what it is told: which act follows `safe` at tick `tick`.
inline Acted obey(const SafeChunk& safe, std::uint64_t tick) {
  return tick < safe.first_tick + safe.horizon
             ? row_of(safe, static_cast<std::uint32_t>(tick - safe.first_tick))
             : Acted{2, 0, 0};
}

}  // namespace fairlead::test
