// The unit of the numbers in a verdict.
#pragma once

#include <string>

#include "fairlead_safety/messages.hpp"

namespace fairlead {

/// "m", "rad/s" and so on, "" where the number has none; `mode` is that of the verdict's part.
std::string unit_of(const Limits& limits, const Verdict& verdict, std::uint8_t mode);

}  // namespace fairlead
