// One chunk against all that can be wrong with it, G002 to G012 and then row by row.
#pragma once

#include <cstdint>
#include <optional>

#include "core/chunk/judgement.hpp"
#include "core/release/acting_rows.hpp"
#include "core/release/claim_table.hpp"
#include "core/trajectory/trajectory_check.hpp"

namespace fairlead {

/// What a chunk has to cite to be of this robot and of now.
struct Identity {
  const Limits& limits;
  std::uint64_t session = 0;  // of the HAL that the gate follows, 0: none
  bool is_armed = false;
  std::uint64_t epoch = 0;
};

/// G002, G003, G004: this robot, this arm epoch, this claim. Nothing that was recorded passes.
/// `claim`: the one that the chunk cites, nullptr if none lives; `source`: of the chunk's key.
Evidence check_identity(const Identity& here, const LiveClaim* claim, const ActionChunk& chunk,
                        const Name& source);

/// G005: strictly increasing, and no leap that would use up the numbers.
Evidence check_sequence(const Limits& limits, const LiveClaim& claim, const ActionChunk& chunk);

/// Where a judgement works: 400 kB, made once. One judgement at a time.
using PathRoom = std::optional<TrajectoryCheck>;

/// G024, G030 to G034 of rows: the predicted configuration after each, where braking from it ends,
/// and whether robot and surroundings allow both. `row_count` is how many pass before the first
/// that does not; of that one the evidence tells. Nothing else is checked: the rows have passed
/// `check_shape` and the other checks of their own.
Judgement judge_path(PathRoom& room, const RobotModel& model, const ClaimLimits& claim,
                     const MeasuredState& state, const ActionChunk& chunk, const JudgedRows& rows,
                     const RowBefore& before, Companions companions);

/// All of a row's checks, row by row: G011 (part), G020, G021, G022, then those of `judge_path`.
/// `chunk` has passed check_shape. A chunk is released or cut for all its parts together.
Judgement judge_rows(PathRoom& room, const RobotModel& model, const ClaimLimits& claim,
                     const MeasuredState& state, const ActionChunk& chunk, const JudgedRows& rows,
                     const RowBefore& before, Companions companions);

/// G006 to G012 and the rows, of chunks of a live claim: from the newest state, and beside what the
/// other claims have released.
class ChunkJudge {
 public:
  /// All must outlive it.
  ChunkJudge(const RobotModel& model, const HalLink& hal, const ActingRows& rows)
      : model_(model), hal_(hal), rows_(rows) {}

  /// A new chunk.
  Judgement judge(LiveClaim& claim, const ActionChunk& chunk);
  /// Its rows from one on, by all checks of a row, with so many queries at most.
  Judgement judge_from(const LiveClaim& claim, const ActionChunk& chunk, std::size_t first_row,
                       std::size_t queries);
  /// G024, G030 to G034: released rows that can act before the next judgement, from a newer state.
  Judgement judge_again(const LiveClaim& claim, const ActionChunk& chunk, std::size_t first_row,
                        std::size_t end_row, std::size_t queries);

 private:
  [[nodiscard]] bool is_waited_for(const LiveClaim& claim) const;
  template <class Judge>
  Judgement judge_beside(const LiveClaim& claim, const ActionChunk& chunk, std::size_t queries,
                         const Judge& judge);

  const RobotModel& model_;
  const HalLink& hal_;
  const ActingRows& rows_;
  PathRoom room_;
};

}  // namespace fairlead
