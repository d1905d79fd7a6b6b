// At boot the gate asks its own core questions whose answers are known, on the limits it loaded:
// a core that was built wrong, or limits that went wrong in memory, show before anything moves.
#pragma once

#include <cstddef>

#include "fairlead_safety/limits.hpp"

namespace fairlead {

/// How many known answers were right. Throws StartFailed, which names part, mode, question and
/// both answers, at the first that is not. Nothing but this process takes part.
std::size_t self_test(const Limits& limits);

}  // namespace fairlead
