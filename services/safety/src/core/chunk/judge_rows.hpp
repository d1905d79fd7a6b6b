// Where the rows of a chunk lead: the predicted configuration after each, where braking from it
// ends, and whether robot and surroundings allow both. Codes G024 and G030 to G034.
#pragma once

#include <cstddef>
#include <memory>
#include <span>

#include "core/chunk/judgement.hpp"
#include "core/kinematics/robot_model.hpp"

namespace fairlead {

/// What another claim has released for the same ticks: its parts move too.
struct Companion {
  RowBefore before;                    // its row in the tick before `row`, as for the claim itself
  const ActionChunk* chunk = nullptr;  // nullptr: no released row left
  std::size_t row = 0;                 // acts in the tick of the judged chunk's first row
  std::size_t end_row = 0;             // its parts hold from this row on
};
using Companions = std::span<const Companion>;

/// Of configurations that one judgement looks at, or one step of all claims together. Good
/// demonstrations take up to 81, chunks made to cause a breach up to 367.
inline constexpr std::size_t max_queries = 512;

/// Which rows of a chunk are judged. Those before `certified_end` can act before the gate judges
/// anew: whatever shares of them happen, they keep to the limits, and so does the stop behind each.
/// Those after it are forecast, by the middle of each gain: they are certified before they act.
struct JudgedRows {
  std::size_t first = 0;
  std::size_t end = 0;
  std::size_t certified_end = 0;
  std::size_t queries = max_queries;

  /// All of them are certified.
  static JudgedRows all(std::size_t first, std::size_t end, std::size_t queries = max_queries) {
    return {first, end, end, queries};
  }
};

/// How many configurations a judgement may query, and has: this bounds the time that it takes.
class QueryBudget {
 public:
  explicit QueryBudget(std::size_t most = max_queries) : most_(most) {}

  /// G030 where none is left.
  Evidence take() {
    if (taken_ == most_)
      return above(code::unreachable, "queries", static_cast<double>(taken_),
                   static_cast<double>(most_), "1", "configurations that one judgement queries");
    ++taken_;
    return {};
  }
  [[nodiscard]] std::size_t taken() const { return taken_; }

 private:
  std::size_t most_;
  std::size_t taken_ = 0;
};

class TrajectoryCheck;

/// Where a judgement works: 400 kB, made once. One judgement at a time.
class PathRoom {
 public:
  PathRoom();
  ~PathRoom();
  PathRoom(const PathRoom&) = delete;
  PathRoom& operator=(const PathRoom&) = delete;

  /// A new walk in place of the last.
  TrajectoryCheck& begin(const RobotModel& model, const ClaimLimits& claim,
                         const MeasuredState& state, const ActionChunk& chunk,
                         const JudgedRows& rows, const RowBefore& before, Companions companions);

 private:
  struct Place;
  std::unique_ptr<Place> place_;
};

/// G024, G030 to G034 of rows, predicted from the measured state. `row_count` is how many pass
/// before the first that does not; of that one the evidence tells. Nothing else is checked: the
/// rows have passed `check_shape` and the other checks of their own.
Judgement judge_path(PathRoom& room, const RobotModel& model, const ClaimLimits& claim,
                     const MeasuredState& state, const ActionChunk& chunk, const JudgedRows& rows,
                     const RowBefore& before, Companions companions);

/// All of a row's checks, row by row: G011 (part), G020, G021, G022, then those of `judge_path`.
/// `chunk` has passed check_shape. A chunk is released or cut for all its parts together.
Judgement judge_rows(PathRoom& room, const RobotModel& model, const ClaimLimits& claim,
                     const MeasuredState& state, const ActionChunk& chunk, const JudgedRows& rows,
                     const RowBefore& before, Companions companions);

}  // namespace fairlead
