// The robot's links in a compiled gate file.
#pragma once

#include "config/strict_json.hpp"
#include "fairlead_safety/limits.hpp"

namespace fairlead {

/// Read `kinematics`; the joints of `limits` are known. Throws ConfigRefused naming the path.
Kinematics read_tree(Section section, const Limits& limits);

/// A part's `tool_frame`: a link's index, no_link where the file says null.
std::size_t read_tool(Section& part, const Kinematics& kinematics);

}  // namespace fairlead
