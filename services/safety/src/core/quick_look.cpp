#include "quick_look.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cstring>

#include "fairlead_safety/mode_blocks.hpp"
#include "joint_range.hpp"
#include "outside_bounds.hpp"

namespace fairlead {
namespace {

// Two joints beside each other in a row: processors calculate with both at once.
using Two = Eigen::Array2d;
constexpr std::size_t two = 2, four = 4;

Two two_of(const void* numbers) {
  Two both;
  std::memcpy(both.data(), numbers, sizeof(double) * two);
  return both;
}

// By place in a row: where its number has to lie, and how far from that of the row before.
struct Ranges {
  std::array<double, max_joints> lower, upper, step;
};

// What two joints are told at least, at most, and by how much it changes from row to row at most.
struct Extent {
  explicit Extent(Two first) : least(first), most(first), before(first) {}

  void add(Two now) {
    const Two difference = now - before;
    least = least.min(now);
    most = most.max(now);
    change = change.max(difference.abs());
    drift += difference;
    before = now;
  }

  Two least, most, before;
  Two change = Two::Zero();
  Two drift = Two::Zero();  // all changes added up: no number if one is none, which the others may
                            // not show
};

bool inside_bounds(const Limits& limits, const MeasuredState& state, const PartLimits& part) {
  for (const std::size_t j : part.joints) {
    const JointLimits& joint = limits.joints[j];
    if (joint.bounded && is_outside(joint.bounds, state.positions[j])) return false;
  }
  return true;
}

void fill_ranges(const Limits& limits, const JointModeLimits& mode, const ActionPart& action,
                 Ranges& ranges) {
  if (action.active.size() != limits.joints.size())  // padding is 0 in every row
    for (std::size_t j = 0; j != limits.joints.size(); ++j)
      ranges.lower[j] = ranges.upper[j] = ranges.step[j] = 0.0;
  for (const std::uint8_t j : action.active) {
    const JointRange range = joint_range(limits.joints[j], mode, action.mode);
    ranges.lower[j] = range.lower;
    ranges.upper[j] = range.upper;
    ranges.step[j] = mode.step_limit[j];
  }
}

bool keeps_to(const Ranges& ranges, const Extent& extent, std::size_t j) {
  return (extent.least >= two_of(&ranges.lower[j])).all() &&
         (extent.most <= two_of(&ranges.upper[j])).all() &&
         (extent.change <= two_of(&ranges.step[j])).all() && (extent.drift == extent.drift).all();
}

}  // namespace

bool certainly_in_order(const Limits& limits, const ModeLimits& modes, const MeasuredState& state,
                        const ActionPart& action, std::size_t first_row, std::size_t horizon) {
  const JointModeLimits* mode = joint_block(modes, action.mode);
  const std::size_t width = limits.joints.size();
  // A joint outside its bounds has to be led back: not a matter of ranges.
  if (mode == nullptr || width < two || first_row >= horizon ||
      !inside_bounds(limits, state, limits.parts[action.part]))
    return false;
  Ranges ranges;
  fill_ranges(limits, *mode, action, ranges);
  const std::size_t stride = width * sizeof(double);
  const std::uint8_t* first = action.values.bytes().data() + first_row * stride;
  // From the last place on; of a width that is no multiple of four the first ones overlap.
  for (std::size_t end = width; end > 0; end -= std::min(end, four)) {
    const std::size_t j = std::max(end, two) - two, k = std::max(end, four) - four;
    const std::uint8_t *left = first + j * sizeof(double), *right = first + k * sizeof(double);
    Extent one(two_of(left)), other(two_of(right));
    for (std::size_t row = 1; row < horizon - first_row; ++row) {
      one.add(two_of(left += stride));
      other.add(two_of(right += stride));
    }
    if (!keeps_to(ranges, one, j) || !keeps_to(ranges, other, k)) return false;
  }
  return true;
}

}  // namespace fairlead
