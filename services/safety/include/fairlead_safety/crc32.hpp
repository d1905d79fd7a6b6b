// CRC-32 (IEEE 802.3, as zlib's): finds accidents in memory or a file, not forgery.
#pragma once

#include <cstdint>

#include "fairlead_safety/fixed.hpp"

namespace fairlead {

/// The CRC of `data` after whatever `crc` already covers; 0 to begin.
std::uint32_t crc32(Bytes data, std::uint32_t crc = 0);

}  // namespace fairlead
