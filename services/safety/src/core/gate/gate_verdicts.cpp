// What a claim is told about its chunks, and what is remembered of the answer.

#include <algorithm>

#include "core/gate/gate_core.hpp"

namespace fairlead {

void Gate::Core::give_verdict(LiveClaim& claim, const ActionChunk& chunk, Bytes frame,
                              const Judgement& judgement, std::uint64_t verdict_id,
                              std::uint64_t received_ns) {
  const Verdict verdict = make_verdict(chunk, claim.source, judgement, verdict_id, received_ns);
  claim.last_seq = chunk.seq;
  claim.newest.store(frame);
  claim.newest_verdict = claim.latest_verdict = verdict;
  (void)verdicts_.push_back(verdict);
  lease_due_ = true;
  if (judgement.outcome == Outcome::refused) {
    // Older released rows stay as they are; in lockstep the tick is now decided as a hold.
    claim.refused_tick = hal_.tick();
    claim.refused_verdict = verdict_id;
  } else {
    claim.plan.release(make_release(claim, judgement, verdict_id), claim.newest.frame());
    note_released(claim);
  }
}

// The same bytes get the same answer: verdict, SafeChunk and lease again, and nothing is counted.
void Gate::Core::answer_again(LiveClaim& claim) {
  ++copies_;
  (void)verdicts_.push_back(claim.newest_verdict);
  const Released* release = claim.plan.current();
  if (release != nullptr && claim.plan.chunk_of(*release).seq == claim.last_seq)
    claim.repeat = true;
  lease_due_ = true;
}

// A verdict that leaves no trace in any claim: it may not even be the claim's own runner. It
// names the claim only if the chunk is the claim's by session, epoch and source.
void Gate::Core::refuse_stranger(const ActionChunk& chunk, const Name& source,
                                 const Evidence& evidence, std::uint64_t received_ns) {
  Judgement judgement;
  judgement.evidence = evidence;
  Verdict verdict = make_verdict(chunk, source, judgement, next_verdict_++, received_ns);
  const LiveClaim* claim = claims_.find(chunk.claim_id);
  const bool own = claim != nullptr && claim->source == source && chunk.source == source &&
                   chunk.session == hal_.session() && chunk.epoch == epoch_;
  if (!own) verdict.claim_id = 0;
  (void)verdicts_.push_back(verdict);
}

Verdict Gate::Core::make_verdict(const ActionChunk& chunk, const Name& source,
                                 const Judgement& judgement, std::uint64_t verdict_id,
                                 std::uint64_t received_ns) {
  const Evidence& evidence = judgement.evidence;
  Verdict verdict;
  verdict.verdict_id = verdict_id;
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
  verdict.limit_source = Text(evidence.limit_source);
  if (judgement.row_count > 0) {
    verdict.released_first = chunk.start_tick + judgement.first_row;
    verdict.released_last = verdict.released_first + judgement.row_count - 1;
  }
  verdict.config_hash = limits_.config_hash;
  verdict.latency_ns = now_ns_ - std::min(now_ns_, received_ns);
  if (!evidence.ok() && !evidence.raises_stop) count(evidence.code);  // a stop counts itself
  ++(judgement.outcome == Outcome::released    ? released_
     : judgement.outcome == Outcome::truncated ? truncated_
                                               : refused_);
  return verdict;
}

Released Gate::Core::make_release(const LiveClaim& claim, const Judgement& judgement,
                                  std::uint64_t verdict_id) const {
  Released release;
  release.verdict_id = verdict_id;
  release.judged_tick = hal_.tick();
  release.first_tick = first_open_tick();
  release.first_row = judgement.first_row;
  release.row_count = static_cast<std::uint32_t>(judgement.row_count);
  release.after = act_before(claim);
  return release;
}

}  // namespace fairlead
