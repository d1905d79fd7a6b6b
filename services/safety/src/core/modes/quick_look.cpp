#include "core/modes/quick_look.hpp"

#include <algorithm>
#include <bit>
#include <cstring>

#include "core/modes/bounds_recovery.hpp"
#include "core/modes/joint_range.hpp"
#include "core/modes/mode_transition.hpp"
#include "fairlead_safety/mode_blocks.hpp"

namespace fairlead {
namespace {

// Two joints beside each other in a row: processors calculate with both at once. A comparison sets
// all bits of a joint of which it is true; it is not true of what is no number.
using Two = double __attribute__((vector_size(16)));
using Truths = std::int64_t __attribute__((vector_size(16)));
constexpr std::size_t two = 2, four = 4;

Two two_of(const void* numbers) {
  Two both;
  std::memcpy(&both, numbers, sizeof both);
  return both;
}

Two magnitude(Two of) { return std::bit_cast<Two>(std::bit_cast<Truths>(of) & INT64_MAX); }

// Whether all that was asked of two joints is true. (Kept as numbers: some compilers take what they
// know of truths apart joint by joint.)
struct Answers {
  void ask(Truths found) { all = found ? all : Two{0.0, 0.0}; }
  [[nodiscard]] bool yes() const { return all[0] + all[1] > 1.0; }

  Two all = {1.0, 1.0};
};

// What the numbers of a row have to keep to, by their place in it.
struct Ranges {
  const double *lower, *upper, *step, *measured;
};

// Room for those of rows that command some joints of the robot, or not where they have to be. What
// such a row leaves out is padding, 0.
struct OwnRanges {
  void fill(const Limits& limits, const JointModeLimits& mode, const MeasuredState& state,
            const ActionPart& action);
  [[nodiscard]] Ranges ranges() const {
    return {lower.data(), upper.data(), step.data(), measured.data()};
  }

  JointColumn lower, upper, step, measured;
};

void OwnRanges::fill(const Limits& limits, const JointModeLimits& mode, const MeasuredState& state,
                     const ActionPart& action) {
  for (JointColumn* column : {&lower, &upper, &step, &measured})
    std::fill_n(column->begin(), limits.joints.size(), 0.0);
  for (const std::uint8_t j : action.active) {
    const JointRange range = joint_range(limits.joints[j], mode, action.mode);
    lower[j] = range.lower;
    upper[j] = range.upper;
    step[j] = mode.step_limit[j];
    measured[j] = state.positions[j];
  }
}

// What two joints have to keep to.
struct Keeper {
  Keeper(Ranges ranges, std::size_t j)
      : lower(two_of(ranges.lower + j)),
        upper(two_of(ranges.upper + j)),
        step(two_of(ranges.step + j)) {}

  [[nodiscard]] Truths keeps(Two now) const { return (now >= lower) & (now <= upper); }
  [[nodiscard]] Truths steps(Two now, Two before) const { return magnitude(now - before) <= step; }

  Two lower, upper, step;
};

// From the first live row on; each has `width` numbers.
struct Rows {
  Rows(const ActionPart& action, std::size_t first_row, std::size_t numbers)
      : first(action.values.bytes().data() + first_row * numbers * sizeof(double)),
        width(numbers) {}
  [[nodiscard]] Two two_at(std::size_t j) const { return two_of(first + j * sizeof(double)); }

  const std::uint8_t* first;
  std::size_t width;
};

// Calls `look` with every place from which on two numbers are looked at. Of an odd width the last
// two overlap with those before.
template <class Look>
void each_two(std::size_t width, const Look& look) {
  for (std::size_t j = 0; j + two <= width; j += two) look(j);
  if (width % two != 0) look(width - two);
}

// The first row keeps to its ranges.
bool begins_in_order(Ranges ranges, Rows rows) {
  Answers in_order;
  each_two(rows.width,
           [&](std::size_t j) { in_order.ask(Keeper(ranges, j).keeps(rows.two_at(j))); });
  return in_order.yes();
}

// The same, and it is a step at most away from where the joints are measured.
bool starts_in_order(Ranges ranges, Rows rows) {
  Answers in_order;
  each_two(rows.width, [&](std::size_t j) {
    const Keeper keeper(ranges, j);
    const Two first = rows.two_at(j);
    in_order.ask(keeper.keeps(first) & keeper.steps(first, two_of(ranges.measured + j)));
  });
  return in_order.yes();
}

// It is that from the row that acts before, too.
bool follows_in_order(Ranges ranges, Rows rows, Rows acted) {
  Answers in_order;
  each_two(rows.width, [&](std::size_t j) {
    in_order.ask(Keeper(ranges, j).steps(rows.two_at(j), acted.two_at(j)));
  });
  return in_order.yes();
}

// Every row after it does, and no number changes by more than a step.
bool goes_on_in_order(Ranges ranges, Rows rows, std::size_t count) {
  const std::size_t stride = rows.width * sizeof(double);
  Answers in_order;
  const auto at = [](const std::uint8_t* row, std::size_t j) {
    return two_of(row + j * sizeof(double));
  };
  // Four at a time, from the last place on; of a width that is no multiple of four the first ones
  // overlap.
  for (std::size_t end = rows.width; end > 0; end -= std::min(end, four)) {
    const std::size_t j = std::max(end, two) - two, k = std::max(j, two) - two;
    const Keeper one(ranges, j), other(ranges, k);
    const std::uint8_t* row = rows.first;
    Two one_before = at(row, j), other_before = at(row, k);
    for (std::size_t i = 1; i < count; ++i) {
      row += stride;
      const Two one_now = at(row, j), other_now = at(row, k);
      in_order.ask(one.keeps(one_now) & one.steps(one_now, one_before) & other.keeps(other_now) &
                   other.steps(other_now, other_before));
      one_before = one_now;
      other_before = other_now;
    }
  }
  return in_order.yes();
}

bool inside_bounds(const Limits& limits, const MeasuredState& state, const PartLimits& part) {
  for (const std::size_t j : part.joints) {
    const JointLimits& joint = limits.joints[j];
    if (joint.bounded && is_outside(joint.bounds, state.positions[j])) return false;
  }
  return true;
}

// Nothing changes but the targets, and those by a step at most, from what acts before or acted
// last.
bool goes_on_as_before(Ranges ranges, Rows rows, const ActionPart& action,
                       const RowBefore& before) {
  if (before.chunk == nullptr) return is_as_remembered(action, before);
  const ActionPart* last = command_before(before, action);
  if (last == nullptr) return is_as_remembered(action, before);
  return is_alike(*last, action) && last->active == action.active &&
         follows_in_order(ranges, rows, Rows(*last, before.row, rows.width));
}

}  // namespace

Certain look_quickly(const PathPlan& plan, const ModeLimits& modes, const MeasuredState& state,
                     const ActionPart& action, std::size_t first_row, std::size_t horizon,
                     const RowBefore& before) {
  const Limits& limits = plan.limits;
  const JointModeLimits* mode = joint_block(modes, action.mode);
  const std::size_t width = limits.joints.size(), count = horizon - first_row;
  if (mode == nullptr || width < two || first_row >= horizon) return Certain::nothing;
  const bool targets = is_target(static_cast<Mode>(action.mode));
  Ranges ranges{plan.lower.data(), plan.upper.data(), mode->step_limit.data(),
                state.positions.data()};
  OwnRanges own;
  if (!targets || action.active.size() != width) {
    // A joint outside its bounds has to be led back: not a matter of ranges. (Any target inside
    // them does that.)
    if (!inside_bounds(limits, state, limits.parts[action.part])) return Certain::nothing;
    own.fill(limits, *mode, state, action);
    ranges = own.ranges();
  }
  const Rows rows(action, first_row, width);
  if (!(targets ? starts_in_order(ranges, rows) : begins_in_order(ranges, rows)) ||
      (count != 1 && !goes_on_in_order(ranges, rows, count)))
    return Certain::nothing;
  return targets && goes_on_as_before(ranges, rows, action, before) ? Certain::starts
                                                                    : Certain::in_order;
}

}  // namespace fairlead
