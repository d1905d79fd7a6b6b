// Rows that repeat the row before: most rows of a robot that waits. What is predicted of a row, and
// every look at it, is made of nothing but where the branches are when it begins, how far shares
// have spread, and what the row and those of companions tell. (Only in the first row it also
// matters what was measured and what acted before.) So where a row led back to where it began, and
// the next one is told the same, that one leads there again, as fast, and is judged alike.

#include <algorithm>

#include "core/kinematics/joint_set.hpp"
#include "core/trajectory/prediction.hpp"

namespace fairlead {
namespace {

// Bit by bit: what differs in any way is another row.
bool told_alike(const ActionPart& action, std::size_t row, std::size_t other,
                const Limits& limits) {
  const std::size_t width = mode_width(action.mode, limits.joints.size());
  const Bytes one = action.values.rows(row, 1, width).bytes();
  const Bytes next = action.values.rows(other, 1, width).bytes();
  return std::equal(one.begin(), one.end(), next.begin());
}

bool told_alike(const ActionChunk& chunk, std::size_t row, const Limits& limits) {
  return std::all_of(chunk.parts.begin(), chunk.parts.end(), [&](const ActionPart& action) {
    return told_alike(action, row, row + 1, limits);
  });
}

}  // namespace

// Every branch ended the newest row where it began it, and so did what is predicted of shares. A
// position that is no number is nowhere.
bool Prediction::leads_nowhere() const {
  for (const std::size_t j : JointsIn(moving_)) {
    if (spread_.lowest[j] != spread_before_.lowest[j]) return false;
    if (spread_.highest[j] != spread_before_.highest[j]) return false;
    for (const Branch& branch : branches())
      if (branch.now[j] != branch.before[j]) return false;
  }
  return true;
}

// A companion holds from its last row on; where it ends it is told something else.
bool Prediction::repeats_for(const Companion& companion) const {
  const std::size_t row = companion.row + steps_ - 1;  // that acted beside the newest
  if (companion.chunk == nullptr || row >= companion.end_row) return true;
  return row + 1 < companion.end_row && told_alike(*companion.chunk, row, plan_.limits);
}

bool Prediction::next_repeats() const {
  return has_settled_ && told_alike(chunk_, row_, plan_.limits) &&
         std::all_of(companions_.begin(), companions_.end(),
                     [this](const Companion& one) { return repeats_for(one); });
}

void Prediction::repeat() {
  row_ = next_row_++;
  ++steps_;
}

}  // namespace fairlead
