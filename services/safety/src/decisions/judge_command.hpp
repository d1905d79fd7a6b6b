// `fairlead-decisions judge LOG`: the recorded steps through this gate again.
#pragma once

#include <string>
#include <vector>

namespace fairlead {

/// What `judge --help` prints.
std::string judge_usage();

/// Prints what it finds. Returns 0 if all is identical (or, with --config, no outcome changed),
/// 1 if something differs, 2 if the log is damaged. Throws ConfigRefused for what cannot be read.
int judge_command(const std::vector<std::string>& words);

}  // namespace fairlead
