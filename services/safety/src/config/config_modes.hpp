// The modes of one part in a compiled gate file.
#pragma once

#include "config/strict_json.hpp"
#include "fairlead_safety/limits.hpp"

namespace fairlead {

/// Read `modes` of a part whose joints are known. Throws ConfigRefused naming the path, also for a
/// mode that has no checker.
void read_modes(Section section, PartLimits& part);

/// Read `transitions` of a part whose modes are known. Throws ConfigRefused naming the path.
void read_transitions(Section& part, PartLimits& limits);

}  // namespace fairlead
