// `fairlead-decisions explain LOG`: what `fairlead why` puts into words.
#pragma once

#include <string>
#include <vector>

namespace fairlead {

/// What `explain --help` prints.
std::string explain_usage();

/// Prints one JSON document; returns 0, also if nothing matches. Throws ConfigRefused for what
/// cannot be read.
int explain_command(const std::vector<std::string>& words);

}  // namespace fairlead
