// Reads a compiled gate file (robots/<id>/gate.<profile>.json) into Limits.
#pragma once

#include <filesystem>
#include <memory>
#include <string_view>

#include "fairlead_safety/limits.hpp"

namespace fairlead {

/// Parse and check the file's text; `config_hash` is the SHA-256 of exactly these bytes.
/// Throws ConfigRefused naming the path of the key that is unknown, missing, duplicate, of the
/// wrong type, not finite, inverted or not positive, or the mode that has no checker.
std::unique_ptr<Limits> parse_limits(std::string_view text);

/// As parse_limits; a refusal also names the file.
std::unique_ptr<Limits> load_limits(const std::filesystem::path& file);

}  // namespace fairlead
