// Which rows of a chunk are judged, beside what, and how far that may go.
#pragma once

#include <cstddef>
#include <span>

#include "core/chunk/judgement.hpp"

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

}  // namespace fairlead
