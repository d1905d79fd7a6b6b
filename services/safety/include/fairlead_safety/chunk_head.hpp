// Whose chunk a frame says it is: the fields that come first, also where the rest is unreadable.
#pragma once

#include <cstdint>

#include "fairlead_safety/fixed.hpp"

namespace fairlead {

struct ChunkHead {
  std::uint64_t session = 0;
  std::uint64_t epoch = 0;
  std::uint64_t claim_id = 0;
};

/// False if the frame does not begin as an ActionChunk does.
bool read_chunk_head(Bytes frame, ChunkHead& head);

}  // namespace fairlead
