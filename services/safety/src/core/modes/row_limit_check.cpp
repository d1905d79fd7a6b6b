#include "core/modes/row_limit_check.hpp"

#include <algorithm>
#include <cmath>

#include "core/modes/bounds_recovery.hpp"
#include "core/modes/joint_range.hpp"
#include "fairlead_safety/mode_blocks.hpp"

namespace fairlead {

bool rows_in_order(const Limits& limits, const ModeLimits& modes, const MeasuredState& state,
                   const ActionPart& action, std::size_t first_row, std::size_t end_row) {
  const JointModeLimits* mode = joint_block(modes, action.mode);
  if (mode == nullptr) return false;
  for (const std::size_t j : limits.parts[action.part].joints) {
    const JointLimits& joint = limits.joints[j];
    if (joint.bounded && is_outside(joint.bounds, state.positions[j])) return false;
  }
  const std::size_t width = limits.joints.size();
  for (const std::uint8_t j : action.active) {
    const JointRange range = joint_range(limits.joints[j], *mode, action.mode);
    const double step = mode->step_limit[j];
    double before = action.values[first_row * width + j];
    bool in_order = true;
    for (std::size_t row = first_row; row < end_row; ++row) {
      const double now = action.values[row * width + j];
      in_order &= (now >= range.lower) & (now <= range.upper) & (std::abs(now - before) <= step);
      before = now;
    }
    if (!in_order) return false;
  }
  return true;
}

RowLimitCheck::RowLimitCheck(const PathPlan& plan, const ClaimLimits& claim,
                             const MeasuredState& state, const ActionChunk& chunk,
                             std::size_t first_row, const RowBefore& before)
    : limits_(plan.limits),
      claim_(claim),
      state_(state),
      chunk_(chunk),
      first_row_(first_row),
      before_(before),
      in_order_(std::all_of(chunk.parts.begin(), chunk.parts.end(), [&](const ActionPart& action) {
        return rows_in_order(limits_, claim.modes[action.part], state, action, first_row,
                             chunk.horizon);
      })) {}

RowView RowLimitCheck::view_of(const ActionPart& action, std::size_t row) const {
  const bool follows = row > first_row_;
  return {limits_, claim_.modes[action.part], state_, row_of(action, row, limits_),
          follows ? row_of(action, row - 1, limits_) : Setpoint{}};
}

Evidence RowLimitCheck::check(std::size_t row) const {
  if (in_order_ && row > first_row_) return {};
  const auto number = static_cast<std::int64_t>(row);
  for (const ActionPart& action : chunk_.parts) {
    const Evidence evidence = check_absolute(view_of(action, row));
    if (!evidence.ok()) return at(evidence, number, limits_.parts[action.part].name);
  }
  for (const ActionPart& action : chunk_.parts) {
    const RowView view = view_of(action, row);
    const Evidence evidence =
        row == first_row_ ? check_start(view, claim_, before_) : check_step(view);
    if (!evidence.ok()) return at(evidence, number, limits_.parts[action.part].name);
  }
  return {};
}

}  // namespace fairlead
