// How much smaller a chunk that was refused would have had to be, and how much larger a released
// one could have been: found by asking the gate.
#pragma once

#include <nlohmann/json.hpp>

#include "decisions/chunk_probe.hpp"

namespace fairlead {

/// For a refused or truncated chunk: what would have been released whole, or why nothing of that
/// kind would; null if that is not a matter of its numbers. `measured` are the positions of the
/// newest state.
nlohmann::json what_would_pass(ChunkProbe& probe, const Verdict& verdict, const Limits& limits,
                               const std::vector<double>& measured);

/// For a released chunk: per part, up to which scale it would have been released, and what the
/// gate says beyond.
nlohmann::json nearest_limits(ChunkProbe& probe, const Limits& limits,
                              const std::vector<double>& measured);

}  // namespace fairlead
