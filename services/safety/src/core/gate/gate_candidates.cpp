// What happens to a candidate chunk, in the order of the codes: cheap and structural first.

#include <algorithm>

#include "core/gate/gate_core.hpp"
#include "fairlead_safety/chunk_head.hpp"

namespace fairlead {
namespace {

// G006: a runner that keeps citing states from the future is not in touch with this robot.
constexpr std::size_t ahead_limit = 5;
constexpr std::uint64_t ahead_window_ticks = 20;

}  // namespace

// G001: anything that is not exactly one well-formed ActionChunk.
void Gate::Core::on_candidate(const Event& event) {
  if (event.source.empty() || event.source.size() > Name::capacity) return count(code::frame);
  const Name source(event.source);
  std::size_t at = 0;
  const FrameFault fault = decode(event.payload, chunk_, at);
  if (fault == FrameFault::none)
    return take_chunk(chunk_, event.payload, source, event.received_ns);
  frame_fault_ = phrase(fault_name(fault), ", at byte ", at, " of ", event.payload.size());
  note_bad_frame(source, event);
}
// Only frames that cite the claim end it: others anybody may have put on its key.
void Gate::Core::note_bad_frame(const Name& source, const Event& event) {
  ActionChunk unknown;
  unknown.session = hal_.session();
  unknown.epoch = epoch_;
  unknown.source = source;
  ChunkHead head;
  LiveClaim* claim =
      read_chunk_head(event.payload, head) && head.session == hal_.session() && head.epoch == epoch_
          ? claims_.find(head.claim_id)
          : nullptr;
  if (claim != nullptr && claim->source == source) {
    unknown.claim_id = claim->id;
    claim->bad_frames.add(hal_.tick());
    const ProtocolLimits& protocol = limits_.protocol;
    if (claim->bad_frames.count(hal_.tick(), protocol.bad_frames_window_ticks) >=
        protocol.bad_frames_limit)
      end_claim(*claim, "too many of its frames are unreadable");
  }
  refuse_stranger(unknown, source, broken_rule(code::frame, "frame", frame_fault_.view()),
                  event.received_ns);
}

// G002, G003, G004: this robot, this arm epoch, this claim. Nothing that was recorded passes.
Evidence Gate::Core::check_identity(const ActionChunk& chunk, const Name& source,
                                    LiveClaim*& claim) {
  if (chunk.session != hal_.session() || chunk.session == 0)
    return broken_rule(code::session, "session", "the HAL session the gate follows");
  if (chunk.robot_hash != limits_.robot_hash)
    return broken_rule(code::session, "robot_hash", "the gate file's robot_hash");
  if (state_ != GateState::armed) return broken_rule(code::epoch, "state", "the gate is not armed");
  if (chunk.epoch != epoch_) return broken_rule(code::epoch, "epoch", "the current arm epoch");
  claim = claims_.find(chunk.claim_id);
  if (claim == nullptr) return broken_rule(code::claim, "claim_id", "a live claim");
  if (!(chunk.source == source) || !(claim->source == source))
    return broken_rule(code::claim, "source",
                       "the claim's own source, in the chunk and in the key");
  for (const ActionPart& part : chunk.parts) {
    if (claim->covers(part.part)) continue;
    const bool known = part.part < limits_.parts.size();
    Evidence evidence = broken_rule(code::claim, "part", "a part of the claim", part.part);
    return known ? of(evidence, limits_.parts[part.part].name) : evidence;
  }
  return {};
}

// G005: strictly increasing, and no leap that would use up the numbers.
Evidence Gate::Core::check_sequence(const LiveClaim& claim, const ActionChunk& chunk) const {
  const auto seq = static_cast<double>(chunk.seq);
  if (chunk.seq <= claim.last_seq)
    return below(code::sequence, "seq", seq, static_cast<double>(claim.last_seq) + 1.0,
                 "strictly increasing");
  const std::uint64_t jump = chunk.seq - claim.last_seq;
  if (jump > limits_.protocol.seq_jump_max)
    return above(code::sequence, "seq", static_cast<double>(jump),
                 static_cast<double>(limits_.protocol.seq_jump_max), "protocol seq_jump_max");
  return {};
}

// G006: made from states that exist, and recent ones. Both ticks are the runner's word, bounded
// by what the gate has seen.
Evidence Gate::Core::check_ticks(const LiveClaim& claim, const ActionChunk& chunk) const {
  const auto number = [](std::uint64_t tick) { return static_cast<double>(tick); };
  const std::uint64_t newest = hal_.tick();
  if (chunk.obs_tick > newest)
    return above(code::age, "obs_tick", number(chunk.obs_tick), number(newest), "the newest state");
  if (chunk.oldest_tick > chunk.obs_tick)
    return above(code::age, "oldest_tick", number(chunk.oldest_tick), number(chunk.obs_tick),
                 "obs_tick");
  const std::uint64_t age = newest - chunk.oldest_tick;
  if (age > claim.limits.age_max_ticks)
    return above(code::age, "age [ticks]", number(age), claim.limits.age_max_ticks,
                 "the claim's age_max_ticks");
  // No check could know the state that a row in the farther future starts from.
  if (chunk.start_tick > first_open_tick())
    return above(code::age, "start_tick", number(chunk.start_tick), number(first_open_tick()),
                 "the next open tick");
  return {};
}

// G012: rows whose tick is past are dropped by index; none left is stale.
Evidence Gate::Core::check_past(const ActionChunk& chunk) const {
  if (first_open_tick() - chunk.start_tick < chunk.horizon) return {};
  return below(code::past, "last row's tick",
               static_cast<double>(chunk.start_tick + chunk.horizon - 1),
               static_cast<double>(first_open_tick()), "the next open tick");
}

// The first tick a row can still be for: in lockstep the robot waits in the newest one. After the
// last tick there is none, and G007 lets no row be for that one.
std::uint64_t Gate::Core::first_open_tick() const {
  return hal_.lockstep() || hal_.tick() == UINT64_MAX ? hal_.tick() : hal_.tick() + 1;
}

void Gate::Core::take_chunk(const ActionChunk& chunk, Bytes frame, const Name& source,
                            std::uint64_t received_ns) {
  LiveClaim* claim = nullptr;
  const Evidence identity = check_identity(chunk, source, claim);
  if (!identity.ok()) return refuse_stranger(chunk, source, identity, received_ns);
  if (claim->newest.is_copy_of(frame)) return answer_again(*claim);
  const Evidence sequence = check_sequence(*claim, chunk);
  if (!sequence.ok()) return refuse_stranger(chunk, source, sequence, received_ns);
  if (chunk.obs_tick == hal_.tick() + 1)
    return claim->waiting.store(frame);  // the gate is the late one
  judge_chunk(*claim, chunk, frame, received_ns);
}

// Lockstep: the world stands until this claim is decided, so a chunk that decides it is no excess.
bool Gate::Core::is_waited_for(const LiveClaim& claim) const {
  return hal_.lockstep() && claim.plan.current() == nullptr && claim.refused_tick != hal_.tick();
}

// G010: the excess over the declared rate, in ticks.
Evidence Gate::Core::check_rate(LiveClaim& claim) {
  const std::size_t recent = claim.admitted.count(hal_.tick(), claim.admitted_window);
  if (recent >= claim.admitted_limit)
    return above(code::rate, "chunks", static_cast<double>(recent + 1),
                 static_cast<double>(claim.admitted_limit), "the claim's chunk_rate_hz");
  claim.admitted.add(hal_.tick());
  return {};
}

void Gate::Core::judge_chunk(LiveClaim& claim, const ActionChunk& chunk, Bytes frame,
                             std::uint64_t received_ns) {
  Judgement judgement;
  Evidence& evidence = judgement.evidence;
  evidence = check_ticks(claim, chunk);
  if (chunk.obs_tick > hal_.tick()) {
    claim.ahead.add(hal_.tick());
    evidence.raises_stop = claim.ahead.count(hal_.tick(), ahead_window_ticks) >= ahead_limit;
  }
  if (evidence.ok()) evidence = check_shape(limits_, claim.limits, chunk);
  if (evidence.ok() && !is_waited_for(claim)) evidence = check_rate(claim);
  if (evidence.ok()) evidence = check_past(chunk);
  if (evidence.ok()) {
    const auto first_row = static_cast<std::size_t>(first_open_tick() - chunk.start_tick);
    judgement = judge_from(claim, chunk, first_row);
  }
  give_verdict(claim, chunk, frame, judgement, next_verdict_++, received_ns);
  if (judgement.evidence.raises_stop) raise_stop(judgement.evidence);
}

// G021: a row that acts but that this claim did not release, or whose numbers are gone, is not
// standing still: nothing can be judged against it. One held tick later a hold is known.
bool Gate::Core::knows_act_before(const LiveClaim& claim) const {
  return act_before(claim).hold != 0 || row_before(claim).chunk != nullptr;
}

Judgement Gate::Core::judge_from(const LiveClaim& claim, const ActionChunk& chunk,
                                 std::size_t first_row) {
  if (knows_act_before(claim)) {
    const FixedVec<Companion, max_claims> companions = companions_of(claim);
    return judge_rows(path_room_, path_plan_, claim.limits, hal_.state(), chunk, first_row,
                      row_before(claim), Companions(companions.begin(), companions.size()));
  }
  Judgement refused;
  refused.evidence =
      broken_rule(code::start, "acted",
                  "a hold or a row of this claim in the tick before; another row acts "
                  "there, of another claim or one replaced: passes after a held tick");
  refused.evidence.row = static_cast<std::int64_t>(first_row);
  return refused;
}

// After the HAL did something else: what is left, from the newest state, under a new verdict.
void Gate::Core::judge_again(LiveClaim& claim) {
  const Released old = *claim.plan.current();
  const ActionChunk& chunk = claim.plan.chunk_of(old);
  const auto first_row = static_cast<std::size_t>(first_open_tick() - chunk.start_tick);
  const std::size_t end_row = old.first_row + old.row_count;
  if (first_row >= end_row) {
    revoke_from(claim, first_open_tick());
    return claim.plan.drop_current();
  }
  Judgement judgement = judge_from(claim, chunk, first_row);
  // Rows that were cut off once stay cut off.
  judgement.row_count = std::min(judgement.row_count, end_row - first_row);
  release_rest(claim, judgement);
}

}  // namespace fairlead
