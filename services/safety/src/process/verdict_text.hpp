// A verdict in words, for the log.
#pragma once

#include <string>

#include "fairlead_safety/messages.hpp"

namespace fairlead {

/// Else it is a rule that `limit_source` words. Older gates told no unit.
bool has_magnitude(const Verdict& verdict);

/// `chunk 7 of runner truncated: G020 arm linear, row 5: 0.09 m, limit 0.0867 m`; see words_of.
std::string verdict_text(const Verdict& verdict);

}  // namespace fairlead
