// The time of day, for people; nothing is decided by it.
#pragma once

#include <string>

namespace fairlead {

/// Now as `2026-11-23T07:54:00.123Z`.
std::string utc_now();

}  // namespace fairlead
