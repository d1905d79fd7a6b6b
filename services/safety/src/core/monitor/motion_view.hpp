// One part, the rows that moved it in the last two ticks, and what was measured before and after
// the newer of them.
#pragma once

#include "core/kinematics/forward_kinematics.hpp"
#include "core/modes/commanded_motion.hpp"

namespace fairlead {

struct MotionView {
  const RobotModel& model;
  const ModeLimits& modes;      // the claim's own
  const MeasuredState& before;  // when the row began
  const MeasuredState& state;   // the newest
  bool consecutive = false;     // the two are of consecutive ticks
  Setpoint now;                 // the row that acted between the two
  Setpoint previous;            // the one of the tick before; of no action: the part held in it
  const Limits& limits = model.limits;

  [[nodiscard]] const PartLimits& part() const { return limits.parts[now.action->part]; }
  [[nodiscard]] std::uint8_t mode() const { return now.action->mode; }
  [[nodiscard]] double period_s() const { return static_cast<double>(limits.period_ns) * 1e-9; }
};

/// How far a joint was measured to move between the two states.
double change_of(const MotionView& view, std::size_t joint);

/// Displacement of the part's tool [m, rad] by its own joints between the two states, along the
/// axes of the row's frame; what other parts did to the tool is left out.
Twist tool_displacement(const MotionView& view);

/// Displacement of the base [m, rad] between the two states along its own axes at the first.
/// False if the part is no base of two slides and a yaw.
bool base_displacement(const MotionView& view, Twist& displacement);

/// Distance [m] and angle [rad] of the tool, as measured last, from the pose that the row commands.
struct PoseError {
  double distance = unset;
  double angle = unset;
};
PoseError pose_error(const MotionView& view);

}  // namespace fairlead
