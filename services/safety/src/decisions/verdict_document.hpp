// Verdicts as JSON, for the commands that read decision logs.
#pragma once

#include <nlohmann/json.hpp>

#include "fairlead_safety/messages.hpp"

namespace fairlead {

/// "released", "truncated" or "refused".
std::string outcome_name(std::uint8_t outcome);

/// An id as people read and type it: 16 hex digits, "none" for 0.
std::string hex_id(std::uint64_t id);

/// Every field of the verdict that is about the chunk; numbers as they are, ids in hex.
nlohmann::json verdict_document(const Verdict& verdict);

}  // namespace fairlead
