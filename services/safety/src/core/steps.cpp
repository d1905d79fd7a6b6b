#include "steps.hpp"

#include <array>
#include <cmath>

#include "evidence.hpp"

namespace fairlead {
namespace {

// A setpoint that acted before: a row of some block, or standing still.
struct Setpoint {
  const NumberView* block = nullptr;  // nullptr: all zero
  std::size_t offset = 0;             // of the row's first number

  double operator[](std::size_t i) const { return block == nullptr ? 0.0 : (*block)[offset + i]; }
};

double distance3(const Setpoint& a, const Setpoint& b, std::size_t first) {
  double sum = 0.0;
  for (std::size_t i = first; i < first + 3; ++i) sum += (a[i] - b[i]) * (a[i] - b[i]);
  return std::sqrt(sum);
}

Evidence limit_step(std::uint32_t code, std::string_view axis, double change, double limit,
                    const Text& source) {
  if (std::abs(change) <= limit) return {};
  return above(code, axis, std::abs(change), limit, source.view());
}

Evidence step_cartesian(std::uint32_t code, const CartesianLimits& mode, const Setpoint& now,
                        const Setpoint& before) {
  const Evidence linear =
      limit_step(code, "linear", distance3(now, before, 0), mode.linear_step_limit, mode.source);
  if (!linear.ok()) return linear;
  return limit_step(code, "angular", distance3(now, before, 3), mode.angular_step_limit,
                    mode.source);
}

const JointModeLimits& joint_limits(const ModeLimits& modes, const ActionPart& action) {
  return action.mode == static_cast<std::uint8_t>(Mode::joint_position) ? modes.joint_position
                                                                        : modes.joint_velocity;
}

// The jump between two setpoints of the same mode, as the part's own controller tolerates it.
// Joint modes: of the joints that both command; padding is not a setpoint.
Evidence step_between(std::uint32_t code, const Limits& limits, const ModeLimits& modes,
                      const ActionPart& action, const Setpoint& now, const ActionPart& last,
                      const Setpoint& before) {
  const auto mode = static_cast<Mode>(action.mode);
  if (mode == Mode::cartesian_delta)
    return step_cartesian(code, modes.cartesian_delta, now, before);
  if (mode == Mode::body_twist) return step_cartesian(code, modes.body_twist, now, before);
  if (mode == Mode::gripper_position)
    return limit_step(code, "opening", now[0] - before[0], modes.gripper_position.step_limit,
                      modes.gripper_position.source);
  if (mode == Mode::composite_mode)
    return limit_step(code, "composite", now[0] - before[0], modes.composite_mode.step_limit,
                      modes.composite_mode.source);
  const JointModeLimits& joint_mode = joint_limits(modes, action);
  for (const std::uint8_t j : action.active) {
    if (!last.active.contains(j)) continue;
    const Evidence evidence = limit_step(code, limits.joints[j].name.view(), now[j] - before[j],
                                         joint_mode.step_limit[j], joint_mode.source);
    if (!evidence.ok()) return evidence;
  }
  return {};
}

// Targets that are positions start where the robot is measured to be. The joint's tolerance is
// added because a measurement may lie that far outside a range that the target keeps.
Evidence start_from_position(const Limits& limits, const ModeLimits& modes,
                             const MeasuredState& state, const ActionPart& action,
                             const Setpoint& first) {
  if (action.mode == static_cast<std::uint8_t>(Mode::gripper_position)) {
    const std::size_t j = limits.parts[action.part].joints[0];
    return limit_step(code::start, "opening", first[0] - state.positions[j],
                      modes.gripper_position.step_limit + limits.joints[j].bounds.tolerance,
                      modes.gripper_position.source);
  }
  for (const std::uint8_t j : action.active) {
    const JointLimits& joint = limits.joints[j];
    const double slack = joint.bounded ? joint.bounds.tolerance : 0.0;
    const Evidence evidence =
        limit_step(code::start, joint.name.view(), first[j] - state.positions[j],
                   modes.joint_position.step_limit[j] + slack, modes.joint_position.source);
    if (!evidence.ok()) return evidence;
  }
  return {};
}

// A velocity that nothing commands yet starts from the measured one.
Evidence start_from_velocity(const Limits& limits, const ModeLimits& modes,
                             const MeasuredState& state, const ActionPart& action,
                             const Setpoint& first, const ActionPart* last) {
  for (const std::uint8_t j : action.active) {
    if (last != nullptr && last->active.contains(j)) continue;
    const Evidence evidence =
        limit_step(code::start, limits.joints[j].name.view(), first[j] - state.velocities[j],
                   modes.joint_velocity.step_limit[j], modes.joint_velocity.source);
    if (!evidence.ok()) return evidence;
  }
  return {};
}

// The base's measured twist along base_link's axes: its joints are two slides along odom's x and
// y and a yaw. False if the part is built otherwise.
bool measured_twist(const Limits& limits, const MeasuredState& state, std::size_t part,
                    std::array<double, 6>& twist) {
  const auto& joints = limits.parts[part].joints;
  if (joints.size() != 3 || limits.joints[joints[0]].kind != JointKind::prismatic ||
      limits.joints[joints[1]].kind != JointKind::prismatic ||
      limits.joints[joints[2]].kind == JointKind::prismatic)
    return false;
  const double yaw = state.positions[joints[2]];
  const double vx = state.velocities[joints[0]];
  const double vy = state.velocities[joints[1]];
  twist = {std::cos(yaw) * vx + std::sin(yaw) * vy,
           std::cos(yaw) * vy - std::sin(yaw) * vx,
           0.0,
           0.0,
           0.0,
           state.velocities[joints[2]]};
  return true;
}

// A joint of the part that is not at standstill, nullptr if there is none.
const JointLimits* moving_joint(const Limits& limits, const MeasuredState& state,
                                std::size_t part) {
  for (const std::size_t j : limits.parts[part].joints)
    if (!(std::abs(state.velocities[j]) < limits.joints[j].standstill_velocity))
      return &limits.joints[j];
  return nullptr;
}

Evidence still(const Limits& limits, const MeasuredState& state, std::size_t part,
               std::string_view rule) {
  const JointLimits* moving = moving_joint(limits, state, part);
  if (moving == nullptr) return {};
  const auto j = static_cast<std::size_t>(moving - limits.joints.begin());
  return above(code::start, moving->name.view(), std::abs(state.velocities[j]),
               moving->standstill_velocity, rule);
}

// A twist after none: against the measured one.
Evidence start_twist(const Limits& limits, const CartesianLimits& mode, const MeasuredState& state,
                     const ActionPart& action, const Setpoint& first) {
  std::array<double, 6> measured{};
  if (!measured_twist(limits, state, action.part, measured))
    return still(limits, state, action.part, "a first twist of this part: from standstill");
  std::array<double, 6> change{};
  for (std::size_t i = 0; i < change.size(); ++i) change[i] = first[i] - measured[i];
  const Evidence linear =
      limit_step(code::start, "linear", std::hypot(change[0], change[1], change[2]),
                 mode.linear_step_limit, mode.source);
  if (!linear.ok()) return linear;
  return limit_step(code::start, "angular", std::hypot(change[3], change[4], change[5]),
                    mode.angular_step_limit, mode.source);
}

// What the measured state says about the first row; cartesian modes are relative to it anyway.
Evidence start_from_state(const Limits& limits, const ModeLimits& modes, const MeasuredState& state,
                          const ActionPart& action, const Setpoint& first, const ActionPart* last) {
  switch (static_cast<Mode>(action.mode)) {
    case Mode::joint_position:
    case Mode::gripper_position:
      return start_from_position(limits, modes, state, action, first);
    case Mode::joint_velocity:
      return start_from_velocity(limits, modes, state, action, first, last);
    default:
      return {};
  }
}

// The same part's command in the row that acts before, nullptr if it had none of this mode.
const ActionPart* command_before(const RowBefore& before, const ActionPart& action) {
  if (before.chunk == nullptr) return nullptr;
  for (const ActionPart& other : before.chunk->parts)
    if (other.part == action.part && other.mode == action.mode) return &other;
  return nullptr;
}

// The row that acts before moves this part in another mode.
bool changes_mode(const RowBefore& before, const ActionPart& action) {
  if (before.chunk == nullptr) return false;
  for (const ActionPart& other : before.chunk->parts)
    if (other.part == action.part) return other.mode != action.mode;
  return false;
}

}  // namespace

Evidence check_step(const Limits& limits, const ModeLimits& modes, const ActionPart& action,
                    std::size_t row) {
  const std::size_t width = mode_width(action.mode, limits.joints.size());
  const Setpoint now{&action.values, row * width};
  const Setpoint before{&action.values, (row - 1) * width};
  return step_between(code::step, limits, modes, action, now, action, before);
}

Evidence check_start(const Limits& limits, const ModeLimits& modes, const MeasuredState& state,
                     const ActionPart& action, std::size_t row, const RowBefore& before) {
  const std::size_t width = mode_width(action.mode, limits.joints.size());
  const Setpoint first{&action.values, row * width};
  const ActionPart* last = command_before(before, action);
  if (changes_mode(before, action)) {
    const Evidence moving =
        still(limits, state, action.part, "a part changes its mode at standstill only");
    if (!moving.ok()) return moving;
  }
  const Evidence evidence = start_from_state(limits, modes, state, action, first, last);
  if (!evidence.ok()) return evidence;
  if (last != nullptr)
    return step_between(code::start, limits, modes, action, first, *last,
                        Setpoint{&last->values, before.row * width});
  // Holding is a delta of zero. A composite switch has no state to start from.
  const auto mode = static_cast<Mode>(action.mode);
  if (mode == Mode::cartesian_delta)
    return step_cartesian(code::start, modes.cartesian_delta, first, Setpoint{});
  if (mode == Mode::body_twist) return start_twist(limits, modes.body_twist, state, action, first);
  return {};
}

}  // namespace fairlead
