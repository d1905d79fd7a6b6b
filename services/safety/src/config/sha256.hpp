// SHA-256 (FIPS 180-4), for the hash that names the gate's configuration.
#pragma once

#include <string>

#include "fairlead_safety/fixed.hpp"

namespace fairlead {

/// The digest of the bytes.
Hash sha256(Bytes data);

/// Lower-case hexadecimal.
std::string to_hex(Bytes data);

}  // namespace fairlead
