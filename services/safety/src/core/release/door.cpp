#include "core/release/door.hpp"

#include <algorithm>

#include "core/modes/commanded_motion.hpp"

namespace fairlead {

// Every row that leaves the gate passes here: as part of a verdict, under its id, out of the bytes
// that were judged. `frame`: those of a new candidate; none: of the current one again.
void Door::pass(LiveClaim& claim, const Judgement& judgement, const Verdict& verdict,
                std::optional<Bytes> frame) {
  claim.latest_verdict = verdict;
  outbox_.tell(verdict);
  if (judgement.outcome == Outcome::refused) {
    // Older released rows stay as they are; in lockstep the tick is now decided as a hold.
    claim.refused_tick = hal_.tick();
    claim.refused_verdict = verdict.verdict_id;
    return;
  }
  Released release;
  release.verdict_id = verdict.verdict_id;
  release.judged_tick = hal_.tick();
  release.first_tick = rows_.first_open_tick();
  release.first_row = judgement.first_row;
  release.row_count = static_cast<std::uint32_t>(judgement.row_count);
  release.after = rows_.act_before(claim);
  if (frame)
    claim.plan.release(release, *frame);
  else
    claim.plan.release_again(release);
  claim.safe_chunk = safe_chunk_of(claim);
  note_sent(claim.safe_chunk);
  history_.note_released(claim);
}

void Door::note_sent(const SafeChunk& safe) {
  Sent sent{safe.verdict_id, safe.horizon, 0};
  for (const ActionPart& part : safe.parts) sent.parts |= 1U << part.part;
  sent_[next_sent_++ % sent_.size()] = sent;
}

bool Door::has_released(std::size_t part, const Acted& acted) const {
  const LiveClaim* holder = claims_.holder_of(part);
  if (holder != nullptr && command_of(part, holder->plan.row_of(acted), limits_).action != nullptr)
    return true;
  return std::any_of(sent_.begin(), sent_.end(), [&](const Sent& sent) {
    return sent.verdict_id == acted.verdict_id && acted.row < sent.row_count &&
           (sent.parts >> part & 1U) != 0;
  });
}

// Its numbers stay in the plan's copy of the candidate.
SafeChunk Door::safe_chunk_of(const LiveClaim& claim) const {
  const Released& release = *claim.plan.current();
  const ActionChunk& chunk = claim.plan.chunk_of(release);
  SafeChunk safe;
  safe.session = chunk.session;
  safe.epoch = chunk.epoch;
  safe.claim_id = claim.id;
  safe.source = chunk.source;
  safe.verdict_id = release.verdict_id;
  safe.judged_tick = release.judged_tick;
  safe.first_tick = release.first_tick;
  safe.horizon = release.row_count;
  safe.after = release.after;
  for (ActionPart part : chunk.parts) {
    const std::size_t width = mode_width(part.mode, limits_.joints.size());
    part.values = part.values.rows(release.first_row, release.row_count, width);
    (void)safe.parts.push_back(part);  // as many places as the chunk has
  }
  return safe;
}

void Door::answer(LiveClaim& claim, const ActionChunk& chunk, Bytes frame,
                  const Judgement& judgement, std::uint64_t received_ns) {
  claim.newest_verdict = make_verdict(chunk, claim.source, judgement, received_ns);
  claim.last_seq = chunk.seq;
  claim.newest.store(frame);
  outbox_.lease_due = true;
  pass(claim, judgement, claim.newest_verdict, claim.newest.frame());
}

void Door::answer_again(LiveClaim& claim) {
  ++outbox_.counters.copies;
  outbox_.tell(claim.newest_verdict);
  const Released* release = claim.plan.current();
  if (release != nullptr && claim.plan.chunk_of(*release).seq == claim.last_seq)
    claim.repeat = true;
  outbox_.lease_due = true;
}

void Door::refuse_stranger(const ActionChunk& chunk, const Name& source, const Evidence& evidence,
                           std::uint64_t received_ns) {
  Judgement judgement;
  judgement.evidence = evidence;
  Verdict verdict = make_verdict(chunk, source, judgement, received_ns);
  const LiveClaim* claim = claims_.find(chunk.claim_id);
  const bool own = claim != nullptr && claim->source == source && chunk.source == source &&
                   chunk.session == hal_.session() && chunk.epoch == machine_.epoch();
  if (!own) verdict.claim_id = 0;
  outbox_.tell(verdict);
}

void Door::answer_rest(LiveClaim& claim, const Judgement& judgement) {
  const ActionChunk& chunk = claim.plan.chunk_of(*claim.plan.current());
  const Verdict verdict = make_verdict(chunk, chunk.source, judgement, outbox_.now_ns);
  revoke_from(claim, rows_.first_open_tick() + judgement.row_count);
  if (judgement.outcome == Outcome::refused) claim.plan.drop_current();
  pass(claim, judgement, verdict, std::nullopt);
}

void Door::revoke_from(LiveClaim& claim, std::uint64_t tick) const {
  if (hal_.lockstep()) return;
  claim.until_tick = std::min(claim.until_tick, tick - 1);
}

Verdict Door::make_verdict(const ActionChunk& chunk, const Name& source, const Judgement& judgement,
                           std::uint64_t received_ns) {
  const Evidence& evidence = judgement.evidence;
  Verdict verdict;
  verdict.verdict_id = next_verdict_++;
  verdict.session = chunk.session;
  verdict.epoch = chunk.epoch;
  verdict.claim_id = chunk.claim_id;
  verdict.source = source;
  verdict.seq = chunk.seq;
  verdict.outcome = static_cast<std::uint8_t>(judgement.outcome);
  verdict.code = evidence.code;
  verdict.row = evidence.row;
  verdict.part = Name(evidence.part);
  verdict.axis = Text(evidence.axis);
  verdict.value = evidence.value;
  verdict.limit = evidence.limit;
  verdict.margin = evidence.margin;
  verdict.unit = Name(evidence.unit);
  verdict.limit_source = Text(evidence.limit_source);
  if (judgement.row_count > 0) {
    verdict.released_first = chunk.start_tick + judgement.first_row;
    verdict.released_last = verdict.released_first + judgement.row_count - 1;
  }
  verdict.config_hash = limits_.config_hash;
  verdict.latency_ns = outbox_.now_ns - std::min(outbox_.now_ns, received_ns);
  if (!evidence.ok() && !evidence.raises_stop)
    outbox_.count(evidence.code);  // a stop counts itself
  Counters& counters = outbox_.counters;
  ++(judgement.outcome == Outcome::released    ? counters.released
     : judgement.outcome == Outcome::truncated ? counters.truncated
                                               : counters.refused);
  return verdict;
}

}  // namespace fairlead
