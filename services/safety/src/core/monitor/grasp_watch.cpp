#include "core/monitor/grasp_watch.hpp"

#include "core/chunk/state_check.hpp"

namespace fairlead {
namespace {

constexpr std::uint32_t still_ticks_to_hold = 3;

// The opening that a row asks for; NaN if it is no gripper's.
double target_of(const Setpoint& row, const Bounds& bounds) {
  switch (static_cast<Mode>(row.action->mode)) {
    case Mode::gripper_position:
      return row[0];
    case Mode::gripper_binary:
      return row[0] == 1.0 ? bounds.lower : bounds.upper;
    default:
      return unset;
  }
}

// The sign of the way from one opening to another: what is lost of a grip lies further that way.
double direction(double from, double to) { return to < from ? -1.0 : 1.0; }

// Whether it was seen to go towards its target: no longer at standstill, or by more than the
// tolerance.
bool approaches(const JointLimits& joint, double target, double commanded_at, double opening,
                double velocity) {
  const double sign = direction(opening, target);
  return sign * velocity >= joint.standstill_velocity ||
         sign * (opening - commanded_at) > joint.bounds.tolerance;
}

}  // namespace

// What was held is still held when the hand is commanded to go further the same way.
GraspWatch::Grip GraspWatch::Grip::commanded(double new_target, double opening_now) const {
  const bool same_way = (target < opening_now) == (new_target < opening_now);
  return Grip{new_target, opening_now, holds && same_way};
}

Evidence GraspWatch::note(const Limits& limits, const MeasuredState& state, std::size_t part,
                          const Setpoint& row) {
  const PartLimits& gripper = limits.parts[part];
  const ScalarLimits& mode = gripper.modes.gripper_position;
  if (!mode.supported) return {};
  const JointLimits& joint = limits.joints[gripper.joints[0]];
  const double opening = state.positions[gripper.joints[0]];
  const double tolerance = joint.bounds.tolerance;
  Grip& grip = grips_[part];
  if (row.action != nullptr) {
    const double target = target_of(row, joint.bounds);
    if (!(std::abs(target - grip.target) <= tolerance)) grip = grip.commanded(target, opening);
  }
  if (std::isnan(grip.target)) return {};
  const bool short_of_it = std::abs(opening - grip.target) > tolerance;
  if (!grip.holds) {
    const double velocity = state.velocities[gripper.joints[0]];
    grip.moved = grip.moved || approaches(joint, grip.target, grip.commanded_at, opening, velocity);
    const bool rests = grip.moved && short_of_it && part_at_standstill(limits, state, gripper);
    grip.still_ticks = rests ? grip.still_ticks + 1 : 0;
    grip.holds = grip.still_ticks >= still_ticks_to_hold;
    grip.opening = opening;
    return {};
  }
  const double lost = direction(grip.opening, grip.target) * (opening - grip.opening);
  if (!(lost <= mode.slip_limit))
    return declared_as(
        above(code::contact, joint.name.view(), lost, mode.slip_limit, position_unit(joint.kind),
              "slip_limit of gripper_position: it lost what it held"),
        "slip_limit: it lost what it held");
  if (!short_of_it) grip = grip.commanded(grip.target, opening);
  return {};
}

}  // namespace fairlead
