// One row of one part's command, and all that it is judged by.
#pragma once

#include <cmath>

#include "core/chunk/judgement.hpp"
#include "core/kinematics/robot_model.hpp"
#include "fairlead_safety/limits.hpp"

namespace fairlead {

/// The numbers that command one part in one tick.
struct Setpoint {
  const ActionPart* action = nullptr;
  std::size_t offset = 0;  // of the row's first number

  double operator[](std::size_t i) const { return action->values[offset + i]; }
  /// Joint modes: whether the joint is commanded; its number is padding if not.
  [[nodiscard]] bool commands(std::size_t joint) const {
    return is_joint_mode(action->mode) &&  // GCOVR_EXCL_BR_LINE: edges of exceptions, both lines
           action->active.contains(        // GCOVR_EXCL_BR_LINE: nothing here throws
               static_cast<std::uint8_t>(joint));
  }
};

inline Setpoint row_of(const ActionPart& action, std::size_t row, const Limits& limits) {
  return {&action, row * mode_width(action.mode, limits.joints.size())};
}

/// What a row commands of one part; of no action if it leaves it out, or there is no row.
inline Setpoint command_of(std::size_t part, const RowBefore& row, const Limits& limits) {
  if (row.chunk == nullptr) return {};
  for (const ActionPart& action : row.chunk->parts)
    if (action.part == part) return row_of(action, row.row, limits);
  return {};
}

struct RowView {
  const RobotModel& model;
  const ModeLimits& modes;  // the claim's own
  const MeasuredState& state;
  Setpoint now;
  Setpoint previous;  // the row before it in its chunk; of no action for the first live row
  JointSet outside;   // measured joints outside their bounds
  const Limits& limits = model.limits;

  [[nodiscard]] const PartLimits& part() const { return limits.parts[now.action->part]; }
  [[nodiscard]] std::uint8_t mode() const { return now.action->mode; }
};

/// One number against a range that includes its ends.
inline Evidence in_range(std::string_view axis, double value, double lower, double upper,
                         std::string_view unit, const Text& source) {
  if (!(value <= upper)) return above(code::absolute, axis, value, upper, unit, source.view());
  if (!(value >= lower)) return below(code::absolute, axis, value, lower, unit, source.view());
  return {};
}

/// A change, of either sign, up to and including its limit.
inline Evidence at_most(std::uint32_t code, std::string_view axis, double value, double limit,
                        std::string_view unit, const Text& source) {
  if (std::abs(value) <= limit) return {};
  return above(code, axis, std::abs(value), limit, unit, source.view());
}

}  // namespace fairlead
