// The robot's shape and surroundings in a compiled gate file.
#pragma once

#include "config/strict_json.hpp"
#include "fairlead_safety/limits.hpp"

namespace fairlead {

/// Read `collision`; the links are known. Throws ConfigRefused naming the path, as all here.
CollisionLimits read_collision(Section section, const Kinematics& kinematics);

/// Read `workspace`.
WorkspaceLimits read_workspace(Section section);

/// Read `base`, null for a robot without zones; the joints of `limits` are known.
BaseLimits read_base(Section& file, const Limits& limits);

}  // namespace fairlead
