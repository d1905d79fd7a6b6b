#include "quick_look.hpp"

#include <cmath>

#include "fairlead_safety/mode_blocks.hpp"
#include "joint_range.hpp"
#include "outside_bounds.hpp"
#include "row_view.hpp"

namespace fairlead {
namespace {

// By place in a row: where its number has to lie, and how far from that of the row before.
struct Ranges {
  std::array<double, max_joints> lower, upper, step;
};

// False if a joint of the part is outside its bounds: then every row has to lead back.
bool fill_ranges(const Limits& limits, const JointModeLimits& mode, const MeasuredState& state,
                 const ActionPart& action, Ranges& ranges) {
  const PartLimits& part = limits.parts[action.part];
  if (action.active.size() != limits.joints.size())  // padding is 0 in every row
    for (std::size_t j = 0; j < limits.joints.size(); ++j)
      ranges.lower[j] = ranges.upper[j] = ranges.step[j] = 0.0;
  for (const std::uint8_t j : action.active) {
    const JointRange range = joint_range(limits.joints[j], mode, action.mode);
    ranges.lower[j] = range.lower;
    ranges.upper[j] = range.upper;
    ranges.step[j] = mode.step_limit[j];
  }
  for (const std::size_t j : part.joints) {
    const JointLimits& joint = limits.joints[j];
    if (joint.bounded && is_outside(joint.bounds, state.positions[j])) return false;
  }
  return true;
}

bool keeps_to(const Ranges& ranges, const Setpoint& now, const Setpoint& before,
              std::size_t width) {
  for (std::size_t j = 0; j < width; ++j) {
    const double value = now[j];
    if (!(value >= ranges.lower[j]) || !(value <= ranges.upper[j]) ||
        !(std::abs(value - before[j]) <= ranges.step[j]))
      return false;
  }
  return true;
}

}  // namespace

std::size_t first_doubtful_row(const Limits& limits, const ModeLimits& modes,
                               const MeasuredState& state, const ActionPart& action,
                               std::size_t first_row, std::size_t horizon) {
  const JointModeLimits* mode = joint_block(modes, action.mode);
  if (mode == nullptr) return first_row;
  Ranges ranges;
  if (!fill_ranges(limits, *mode, state, action, ranges)) return first_row;
  const std::size_t width = limits.joints.size();
  Setpoint before{&action, first_row * width};  // the first row has none in its chunk
  for (std::size_t row = first_row; row < horizon; ++row) {
    const Setpoint now{&action, row * width};
    if (!keeps_to(ranges, now, before, width)) return row;
    before = now;
  }
  return horizon;
}

}  // namespace fairlead
