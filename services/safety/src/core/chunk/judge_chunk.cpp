// What is wrong with a chunk, in the order of the codes: cheap and structural first. (G001 is
// whether its bytes are one at all: wire/codec.cpp.)

#include "core/chunk/judge_chunk.hpp"

#include <algorithm>

#include "core/modes/row_limit_check.hpp"

namespace fairlead {
namespace {

// G006: a runner that keeps citing states from the future is not in touch with this robot.
constexpr std::size_t ahead_limit = 5;
constexpr std::uint64_t ahead_window_ticks = 20;

double number(std::uint64_t tick) { return static_cast<double>(tick); }

}  // namespace

Evidence check_identity(const Identity& here, const LiveClaim* claim, const ActionChunk& chunk,
                        const Name& source) {
  // G002
  if (chunk.session != here.session || chunk.session == 0)
    return broken_rule(code::session, "session", "the HAL session the gate follows");
  if (chunk.robot_hash != here.limits.robot_hash)
    return broken_rule(code::session, "robot_hash", "the gate file's robot_hash");
  // G003
  if (!here.is_armed) return broken_rule(code::epoch, "state", "an armed gate");
  if (chunk.epoch != here.epoch) return broken_rule(code::epoch, "epoch", "the current arm epoch");
  // G004
  if (claim == nullptr) return broken_rule(code::claim, "claim_id", "a live claim");
  if (!(chunk.source == source) || !(claim->source == source))
    return broken_rule(code::claim, "source", "its claim's source in chunk and key");
  for (const ActionPart& part : chunk.parts) {
    if (claim->covers(part.part)) continue;
    const bool known = part.part < here.limits.parts.size();
    Evidence evidence = broken_rule(code::claim, "part", "a part of the claim", part.part);
    return known ? of(evidence, here.limits.parts[part.part].name) : evidence;
  }
  return {};
}

Evidence check_sequence(const Limits& limits, const LiveClaim& claim, const ActionChunk& chunk) {
  if (chunk.seq <= claim.last_seq)
    return below(code::sequence, "seq", number(chunk.seq), number(claim.last_seq) + 1.0, "1",
                 "strictly increasing");
  const std::uint64_t jump = chunk.seq - claim.last_seq;
  if (jump > limits.protocol.seq_jump_max)
    return above(code::sequence, "seq", number(jump), number(limits.protocol.seq_jump_max), "1",
                 "protocol seq_jump_max");
  return {};
}

namespace {

// G006: made from states that exist, and recent ones. Both ticks are the runner's word, bounded
// by what the gate has seen: `newest`, the tick of the newest state.
Evidence check_ticks(const LiveClaim& claim, const ActionChunk& chunk, std::uint64_t newest,
                     std::uint64_t first_open_tick) {
  if (chunk.obs_tick > newest)
    return above(code::age, "obs_tick", number(chunk.obs_tick), number(newest), "ticks",
                 "the newest state");
  if (chunk.oldest_tick > chunk.obs_tick)
    return above(code::age, "oldest_tick", number(chunk.oldest_tick), number(chunk.obs_tick),
                 "ticks", "obs_tick");
  const std::uint64_t age = newest - chunk.oldest_tick;
  if (age > claim.limits.age_max_ticks)
    return above(code::age, "age", number(age), claim.limits.age_max_ticks, "ticks",
                 "the claim's age_max_ticks");
  // No check could know the state that a row in the farther future starts from.
  if (chunk.start_tick > first_open_tick)
    return above(code::age, "start_tick", number(chunk.start_tick), number(first_open_tick),
                 "ticks", "the next open tick");
  return {};
}

// G006, too: whether citing a state that is still to come has become a habit.
bool is_out_of_touch(LiveClaim& claim, const ActionChunk& chunk, std::uint64_t newest) {
  if (chunk.obs_tick <= newest) return false;
  claim.ahead.add(newest);
  return claim.ahead.count(newest, ahead_window_ticks) >= ahead_limit;
}

// G007, G008, G009: check_shape, in chunk/shape.cpp.

// G010: the excess over the declared rate, in ticks.
Evidence check_rate(LiveClaim& claim, std::uint64_t newest) {
  const std::size_t recent = claim.admitted.count(newest, claim.admitted_window);
  if (recent >= claim.admitted_limit)
    return above(code::rate, "chunks", static_cast<double>(recent + 1),
                 static_cast<double>(claim.admitted_limit), "1", "the claim's chunk_rate_hz");
  claim.admitted.add(newest);
  return {};
}

// G012: rows whose tick is past are dropped by index; none left is stale.
Evidence check_past(const ActionChunk& chunk, std::uint64_t first_open_tick) {
  if (first_open_tick - chunk.start_tick < chunk.horizon) return {};
  return below(code::past, "last row's tick", number(chunk.start_tick + chunk.horizon - 1),
               number(first_open_tick), "ticks", "the next open tick");
}

// Rows in order, up to the first that `check` finds fault with.
template <class Check>
Judgement judge_each(const JudgedRows& rows, const TrajectoryCheck& by_path, const Check& check) {
  Judgement judgement;
  judgement.first_row = rows.first;
  for (std::size_t row = rows.first; row < rows.end; ++row) {
    judgement.evidence = check(row);
    if (!judgement.evidence.ok()) break;
    ++judgement.row_count;
  }
  judgement.configurations = by_path.configurations();
  if (judgement.row_count == 0) return judgement;  // refused, by its first row
  judgement.outcome = judgement.evidence.ok() ? Outcome::released : Outcome::truncated;
  return judgement;
}

}  // namespace

// Lockstep: the world stands until this claim is decided, so a chunk that decides it is no excess.
bool ChunkJudge::is_waited_for(const LiveClaim& claim) const {
  return hal_.lockstep() && claim.plan.current() == nullptr && claim.refused_tick != hal_.tick();
}

Judgement ChunkJudge::judge(LiveClaim& claim, const ActionChunk& chunk) {
  const std::uint64_t newest = hal_.tick();
  const std::uint64_t first_open_tick = rows_.first_open_tick();
  Judgement judgement;
  Evidence& evidence = judgement.evidence;
  evidence = check_ticks(claim, chunk, newest, first_open_tick);  // G006
  evidence.raises_stop = is_out_of_touch(claim, chunk, newest);
  if (evidence.ok()) evidence = check_shape(model_.limits, claim.limits, chunk);     // G007 to G009
  if (evidence.ok() && !is_waited_for(claim)) evidence = check_rate(claim, newest);  // G010
  if (evidence.ok()) evidence = check_past(chunk, first_open_tick);                  // G012
  if (!evidence.ok()) return judgement;
  return judge_from(claim, chunk, static_cast<std::size_t>(first_open_tick - chunk.start_tick),
                    max_queries);
}

// Where others either act or hold in the tick that runs: as many rows as pass beside both.
template <class Judge>
Judgement ChunkJudge::judge_beside(const LiveClaim& claim, const ActionChunk& chunk,
                                   std::size_t queries, const Judge& judge) {
  const auto judge_while = [&](bool holding, std::size_t queries_left) {
    const FixedVec<Companion, max_claims> companions = rows_.companions_of(claim, chunk, holding);
    return judge(Companions(companions.begin(), companions.size()), queries_left);
  };
  Judgement judgement = judge_while(false, queries);
  if (judgement.row_count == 0 || !rows_.others_may_hold(claim)) return judgement;
  Judgement held = judge_while(true, queries - judgement.configurations);
  held.configurations += judgement.configurations;
  if (held.row_count < judgement.row_count) return held;
  judgement.configurations = held.configurations;
  return judgement;
}

Judgement ChunkJudge::judge_from(const LiveClaim& claim, const ActionChunk& chunk,
                                 std::size_t first_row, std::size_t queries) {
  if (rows_.knows_act_before(claim)) {
    return judge_beside(claim, chunk, queries, [&](Companions companions, std::size_t left) {
      const JudgedRows rows{first_row, chunk.horizon, first_row + rows_.before_next_judgement(),
                            left};
      return judge_rows(room_, model_, claim.limits, hal_.state(), chunk, rows,
                        rows_.row_before(claim), companions);
    });
  }
  Judgement refused;
  refused.evidence =
      broken_rule(code::start, "acted", "a held tick after another's or a replaced row");
  refused.evidence.row = static_cast<std::int64_t>(first_row);
  return refused;
}

Judgement ChunkJudge::judge_again(const LiveClaim& claim, const ActionChunk& chunk,
                                  std::size_t first_row, std::size_t end_row, std::size_t queries) {
  const std::size_t end = std::min(end_row, first_row + rows_.before_next_judgement());
  return judge_beside(claim, chunk, queries, [&](Companions companions, std::size_t left) {
    return judge_path(room_, model_, claim.limits, hal_.state(), chunk,
                      JudgedRows::all(first_row, end, left), rows_.row_before(claim), companions);
  });
}

Judgement judge_rows(PathRoom& room, const RobotModel& model, const ClaimLimits& claim,
                     const MeasuredState& state, const ActionChunk& chunk, const JudgedRows& rows,
                     const RowBefore& before, Companions companions) {
  const RowLimitCheck by_limits{model, claim, state, chunk, rows.first, before};
  TrajectoryCheck& by_path = room.emplace(model, claim, state, chunk, rows, before, companions);
  return judge_each(rows, by_path, [&](std::size_t row) {
    const Evidence evidence = by_limits.check(row);
    return evidence.ok() ? by_path.check_next() : evidence;
  });
}

Judgement judge_path(PathRoom& room, const RobotModel& model, const ClaimLimits& claim,
                     const MeasuredState& state, const ActionChunk& chunk, const JudgedRows& rows,
                     const RowBefore& before, Companions companions) {
  TrajectoryCheck& by_path = room.emplace(model, claim, state, chunk, rows, before, companions);
  return judge_each(rows, by_path, [&](std::size_t) { return by_path.check_next(); });
}

Evidence check_running(const RobotModel& model, const ClaimLimits& claim,
                       const MeasuredState& state, const ActionChunk& chunk, std::size_t row) {
  const Limits& limits = model.limits;
  const JointSet outside = outside_of(limits, state);
  for (const ActionPart& action : chunk.parts) {
    const Evidence evidence = check_acting(
        {model, claim.modes[action.part], state, row_of(action, row, limits), {}, outside});
    if (!evidence.ok())
      return at(evidence, static_cast<std::int64_t>(row), limits.parts[action.part].name);
  }
  return {};
}

}  // namespace fairlead
