// Modes of one number: a gripper's opening or switch, and the composite switch.

#include <cmath>

#include "core/modes/row_limit_check.hpp"
#include "fairlead_safety/mode_blocks.hpp"

namespace fairlead {
namespace {

const ScalarLimits& block_of(const RowView& view) { return *scalar_block(view.modes, view.mode()); }

bool is_opening(const RowView& view) {
  return view.mode() == static_cast<std::uint8_t>(Mode::gripper_position);
}

std::string_view axis_of(const RowView& view) { return is_opening(view) ? "opening" : "composite"; }

std::string_view unit_of(const RowView& view) {
  return is_opening(view) ? position_unit(view.limits.joints[view.part().joints[0]].kind) : "1";
}

}  // namespace

Evidence scalar_absolute(const RowView& view) {
  const ScalarLimits& mode = block_of(view);
  return in_range(axis_of(view), view.now[0], mode.lower, mode.upper, unit_of(view), mode.source);
}

Evidence binary_absolute(const RowView& view) {
  const double value = view.now[0];
  if (value == 0.0 || value == 1.0) return {};
  constexpr std::string_view rule = "exactly 0 (open) or 1 (closed)";
  // The nearer of the two is the limit; its margin is how far off the value is.
  Evidence evidence = above(code::absolute, "closed", value, value < 0.5 ? 0.0 : 1.0, "1", rule);
  evidence.margin = -std::abs(value - evidence.limit);
  return evidence;
}

// The opening starts where it is measured; the tolerance as for any joint target.
Evidence gripper_start(const RowView& view, const Setpoint*) {
  const ScalarLimits& mode = view.modes.gripper_position;
  const std::size_t j = view.part().joints[0];
  return at_most(code::start, "opening", view.now[0] - view.state.positions[j],
                 mode.step_limit + view.limits.joints[j].bounds.tolerance, unit_of(view),
                 mode.source);
}

Evidence scalar_step(std::uint32_t code, const RowView& view, const Setpoint& before) {
  const ScalarLimits& mode = block_of(view);
  return at_most(code, axis_of(view), view.now[0] - before[0], mode.step_limit, unit_of(view),
                 mode.source);
}

}  // namespace fairlead
