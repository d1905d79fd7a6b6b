// Standstill, wherever it is asked.
#pragma once

#include "core/chunk/evidence.hpp"

namespace fairlead {

/// How fast measured joint `i` went between two states [rad/s or m/s], beyond the noise of its
/// encoder: what its velocity does not say if that channel is stuck.
double travel_speed(const Limits& limits, std::size_t i, double from, double to,
                    std::uint64_t ticks);

/// The part's first joint that does not stand still, by its velocity or by its positions; `rule`
/// says what for, the joint's source if it is empty.
Evidence check_still(std::uint32_t code, const Limits& limits, const MeasuredState& state,
                     const PartLimits& part, std::string_view rule = {});

bool part_at_standstill(const Limits& limits, const MeasuredState& state, const PartLimits& part);

/// Every measured joint, also those that nothing commands.
bool at_standstill(const Limits& limits, const MeasuredState& state);

}  // namespace fairlead
