#include "fairlead_safety/chunk_head.hpp"

#include "core/wire/reader.hpp"
#include "fairlead_safety/action_messages.hpp"

namespace fairlead {

bool read_chunk_head(Bytes frame, ChunkHead& head) {
  Reader in(frame);
  (void)in.array();
  if (in.unsigned_number(UINT64_MAX) != ActionChunk::type_id) return false;
  (void)in.unsigned_number(UINT64_MAX);  // version
  (void)in.binary();                     // robot_hash
  head.session = in.unsigned_number(UINT64_MAX);
  head.epoch = in.unsigned_number(UINT64_MAX);
  head.claim_id = in.unsigned_number(UINT64_MAX);
  return in.ok();
}

}  // namespace fairlead
