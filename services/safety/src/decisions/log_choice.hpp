// Which log a command is about: a file, or the newest run of a folder.
#pragma once

#include <filesystem>
#include <string>

namespace fairlead {

/// Throws ConfigRefused if there is none.
std::filesystem::path choose_log(const std::string& path);

}  // namespace fairlead
