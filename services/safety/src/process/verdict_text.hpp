// A verdict in words, for the log.
#pragma once

#include <string>

#include "fairlead_safety/messages.hpp"

namespace fairlead {

/// For example `chunk 7 of runner truncated: G020 arm linear, row 5: 0.09, limit 0.0867 (SOURCE)`.
std::string verdict_text(const Verdict& verdict);

/// Without where a limit is from, which may be a page of text: `fairlead why` has it.
std::string verdict_line(Verdict verdict);

}  // namespace fairlead
