#include "core/gate/candidates.hpp"

#include "fairlead_safety/codec.hpp"

namespace fairlead {

// G001: anything that is not exactly one well-formed ActionChunk.
void Candidates::on_candidate(const Event& event) {
  if (event.source.empty() || event.source.size() > Name::capacity)
    return outbox_.count(code::frame);
  const Name source(event.source);
  std::size_t at = 0;
  const FrameFault fault = decode(event.payload, chunk_, &at);
  if (fault != FrameFault::none) return refuse_frame(fault, at, source, event);
  take_chunk(chunk_, event.payload, source, event.received_ns);
}

void Candidates::take_chunk(const ActionChunk& chunk, Bytes frame, const Name& source,
                            std::uint64_t received_ns) {
  const Identity here{limits_, hal_.session(), machine_.is_armed(), machine_.epoch()};
  LiveClaim* claim = claims_.find(chunk.claim_id);
  const Evidence identity = check_identity(here, claim, chunk, source);
  if (!identity.ok()) return door_.refuse_stranger(chunk, source, identity, received_ns);
  if (claim->newest.is_copy_of(frame)) return door_.answer_again(*claim);
  const Evidence sequence = check_sequence(limits_, *claim, chunk);
  if (!sequence.ok()) return door_.refuse_stranger(chunk, source, sequence, received_ns);
  if (chunk.obs_tick == hal_.tick() + 1)
    return let_wait(*claim, frame, received_ns);  // the gate is the late one
  const Judgement judgement = judge_.judge(*claim, chunk);
  door_.answer(*claim, chunk, frame, judgement, received_ns);
  if (judgement.evidence.raises_stop) machine_.raise_stop(judgement.evidence);
}

void Candidates::let_wait(LiveClaim& claim, Bytes frame, std::uint64_t received_ns) {
  if (claim.waiting.is_copy_of(frame)) return;
  if (!claim.waiting.empty())
    door_.refuse_stranger(
        claim.waiting.chunk(), claim.source,
        broken_rule(code::age, "obs_tick", "the state that it cites before a newer chunk"),
        received_ns);
  claim.waiting.store(frame);
}

void Candidates::take_waiting() {
  for (LiveClaim& claim : claims_.places()) {
    if (!claim.live() || claim.waiting.empty()) continue;
    const Name source = claim.source;
    chunk_ = claim.waiting.chunk();
    take_chunk(chunk_, claim.waiting.frame(), source, outbox_.now_ns);
    claim.waiting.clear();
  }
}

// Only frames that cite the claim end it: others anybody may have put on its key.
void Candidates::refuse_frame(FrameFault fault, std::size_t at, const Name& source,
                              const Event& event) {
  const Text words =
      phrase("a chunk, got ", fault_name(fault), ", at byte ", at, " of ", event.payload.size());
  ActionChunk unknown;
  unknown.session = hal_.session();
  unknown.epoch = machine_.epoch();
  unknown.source = source;
  ChunkHead head;
  LiveClaim* claim = read_chunk_head(event.payload, head) && head.session == hal_.session() &&
                             head.epoch == machine_.epoch()
                         ? claims_.find(head.claim_id)
                         : nullptr;
  if (claim != nullptr && claim->source == source) {
    unknown.claim_id = claim->id;
    claim->bad_frames.add(hal_.tick());
    const ProtocolLimits& protocol = limits_.protocol;
    if (claim->bad_frames.count(hal_.tick(), protocol.bad_frames_window_ticks) >=
        protocol.bad_frames_limit)
      machine_.end_claim(*claim, "too many of its frames are unreadable");
  }
  door_.refuse_stranger(unknown, source, broken_rule(code::frame, "frame", Rule::made_of(words)),
                        event.received_ns);
}

}  // namespace fairlead
