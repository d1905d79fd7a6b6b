#include "prediction.hpp"

#include <Eigen/Geometry>
#include <cmath>

#include "fairlead_safety/mode_blocks.hpp"
#include "tool_motion.hpp"

namespace fairlead {
namespace {

bool is_target(std::uint8_t mode) {
  return mode == static_cast<std::uint8_t>(Mode::joint_position) ||
         mode == static_cast<std::uint8_t>(Mode::dex_hand_joint);
}

bool is_pose(const ActionPart& action) {
  return action.mode == static_cast<std::uint8_t>(Mode::cartesian_pose);
}

// The tracking model of a mode, nullptr where all of a row happens.
const Gain* gain_block(const ModeLimits& modes, std::uint8_t mode) {
  if (mode == static_cast<std::uint8_t>(Mode::joint_velocity)) return &modes.joint_velocity.gain;
  const CartesianLimits* norms = norm_block(modes, mode);
  return norms == nullptr ? nullptr : &norms->gain;
}

bool is_gripper(std::uint8_t mode) {
  return mode == static_cast<std::uint8_t>(Mode::gripper_binary) ||
         mode == static_cast<std::uint8_t>(Mode::gripper_position);
}

// Joints that a command moves, as far as it is predicted.
JointSet moved_by(const PathPlan& plan, const ActionPart& action) {
  if (is_gripper(action.mode)) return 0;
  if (!is_joint_mode(action.mode)) return plan.part_joints[action.part];
  JointSet joints = 0;
  for (const std::uint8_t j : action.active) joints |= only(j);
  return joints;
}

Motion6 six_of(const Setpoint& row) {
  Motion6 numbers;
  numbers << row[0], row[1], row[2], row[3], row[4], row[5];
  return numbers;
}

}  // namespace

double Prediction::Command::gain(std::size_t branch) const {
  const Gain* gain = gain_block(modes, action.mode);
  if (gain == nullptr) return 1.0;
  return branch == 0 ? gain->lower : gain->upper;
}

Prediction::Prediction(const PathPlan& plan, const ClaimLimits& claim, const MeasuredState& state,
                       const ActionChunk& chunk, std::size_t first_row, const RowBefore& before,
                       Companions companions)
    : plan_(plan),
      claim_(claim),
      state_(state),
      chunk_(chunk),
      companions_(companions),
      next_row_(first_row) {
  include(chunk, commanded_);
  moving_ |= commanded_;
  for (const Companion& companion : companions) {
    if (companion.chunk != nullptr) include(*companion.chunk, moving_);
    if (companion.before.chunk != nullptr) include(*companion.before.chunk, moving_);
  }
  if (before.chunk != nullptr) include(*before.chunk, moving_);
  start_still();
  if (before.measured) {
    if (before.chunk != nullptr) note_targets(*before.chunk, before.row);
  } else {
    (void)apply_rows(before, 0, true);
  }
}

// A joint that nothing commands stays; one that is measured to move brakes from there.
void Prediction::start_still() {
  Branch& first = branches_[0];
  for (std::size_t j = 0; j < state_.count; ++j) {
    first.now[j] = state_.positions[j];
    first.speed[j] = 0.0;
    if (j >= plan_.limits.joints.size()) continue;
    const double speed = state_.velocities[j];
    if (std::abs(speed) < plan_.limits.joints[j].standstill_velocity) continue;
    first.speed[j] = speed;
    moving_ |= only(j);
  }
  first.before = first.now;
  if (branch_count_ == 2) branches_[1] = first;
}

void Prediction::include(const ActionChunk& chunk, JointSet& joints) {
  for (const ActionPart& action : chunk.parts) {
    joints |= moved_by(plan_, action);
    const Gain* gain = gain_block(plan_.limits.parts[action.part].modes, action.mode);
    if (gain != nullptr && gain->lower != gain->upper) branch_count_ = 2;
  }
}

void Prediction::note_targets(const ActionChunk& chunk, std::size_t row) {
  for (const ActionPart& action : chunk.parts) {
    if (!is_target(action.mode)) continue;
    const Setpoint targets = row_of(action, row, plan_.limits);
    for (const std::uint8_t j : action.active) {
      told_[j] = targets[j];
      targets_told_ |= only(j);
    }
  }
}

// Rows of one tick, of the chunk and its companions. A pose is reached for last: it depends on
// where other parts carry its own.
Evidence Prediction::apply_rows(const RowBefore& own, std::size_t steps, bool before) {
  Evidence fault;
  for (const bool poses : {false, true}) {
    if (own.chunk != nullptr) {
      const Evidence evidence = apply_row(*own.chunk, own.row, true, poses);
      if (fault.ok()) fault = evidence;
    }
    for (const Companion& companion : companions_) {
      if (before && companion.before.chunk != nullptr)
        (void)apply_row(*companion.before.chunk, companion.before.row, false, poses);
      if (!before && companion.chunk != nullptr && companion.row + steps < companion.end_row)
        (void)apply_row(*companion.chunk, companion.row + steps, false, poses);
    }
  }
  return fault;
}

Evidence Prediction::advance() {
  row_ = next_row_++;
  for (std::size_t i = 0; i < branch_count_; ++i) branches_[i].before = branches_[i].now;
  Evidence fault = apply_rows(RowBefore{&chunk_, row_}, steps_++, false);
  return fault.ok() ? check_finite() : fault;
}

Evidence Prediction::apply_row(const ActionChunk& chunk, std::size_t row, bool own, bool poses) {
  for (const ActionPart& action : chunk.parts) {
    if (is_pose(action) != poses) continue;
    const ModeLimits& modes =
        own ? claim_.modes[action.part] : plan_.limits.parts[action.part].modes;
    const Command command{action, modes, row_of(action, row, plan_.limits)};
    for (std::size_t i = 0; i < branch_count_; ++i) {
      const Evidence evidence = apply(command, i);
      if (!evidence.ok()) return at(evidence, -1, plan_.limits.parts[action.part].name);
    }
  }
  if (!poses) note_targets(chunk, row);
  return {};
}

Evidence Prediction::apply(const Command& command, std::size_t index) {
  Branch& branch = branches_[index];
  switch (static_cast<Mode>(command.action.mode)) {
    case Mode::joint_position:
    case Mode::dex_hand_joint:
      apply_targets(command, branch);
      return {};
    case Mode::joint_velocity:
      apply_velocities(command, index);
      return {};
    case Mode::joint_torque:
      apply_torques(command, branch);
      return {};
    case Mode::cartesian_delta:
    case Mode::cartesian_twist:
      return apply_tool_motion(command, index);
    case Mode::cartesian_pose:
      return apply_pose(command, branch);
    case Mode::body_twist:
      apply_body_twist(command, index);
      return {};
    default:  // a gripper stays, a switch moves nothing
      return {};
  }
}

// No joint is faster than its limit: of a row that asks for more, the controller makes less.
void Prediction::note_speed(Branch& branch, std::size_t joint, double change) const {
  const double limit = plan_.limits.joints[joint].velocity_limit;
  const double speed = change / plan_.period_s;
  branch.speed[joint] = speed > limit ? limit : speed < -limit ? -limit : speed;
}

// A target is reached; how fast, says the row before it: what is measured may lag behind.
void Prediction::apply_targets(const Command& command, Branch& branch) {
  for (const std::uint8_t j : command.action.active) {
    const double target = command.row[j];
    const double from = (targets_told_ & only(j)) != 0 ? told_[j] : branch.now[j];
    note_speed(branch, j, target - from);
    branch.now[j] = target;
  }
}

void Prediction::apply_velocities(const Command& command, std::size_t index) {
  Branch& branch = branches_[index];
  for (const std::uint8_t j : command.action.active) {
    const double change = command.gain(index) * command.row[j] * plan_.period_s;
    note_speed(branch, j, change);
    branch.now[j] += change;
  }
}

void Prediction::apply_torques(const Command& command, Branch& branch) {
  for (const std::uint8_t j : command.action.active) branch.speed[j] = state_.velocities[j];
}

// From the configuration before the row, whatever other parts do in it.
Evidence Prediction::apply_tool_motion(const Command& command, std::size_t index) {
  Branch& branch = branches_[index];
  const bool twist = command.action.mode == static_cast<std::uint8_t>(Mode::cartesian_twist);
  const double share = command.gain(index) * (twist ? plan_.period_s : 1.0);
  const Motion6 told = share * six_of(command.row);
  const Eigen::Matrix3d axes = frame_pose(plan_, command.action.frame_id, branch.before).rotation;
  Motion6 motion;
  motion << axes * told.head<3>(), axes * told.tail<3>();
  Joints after = branch.before;
  const Evidence evidence = move_tool(plan_, plan_.tools[command.action.part], motion, after);
  for (const std::size_t j : plan_.limits.parts[command.action.part].joints) {
    const double change = after[j] - branch.before[j];
    note_speed(branch, j, change);
    branch.now[j] += change;
  }
  return evidence;
}

Evidence Prediction::apply_pose(const Command& command, Branch& branch) {
  const FramePose frame = frame_pose(plan_, command.action.frame_id, branch.now);
  const Setpoint& row = command.row;
  const Eigen::Quaterniond told(row[6], row[3], row[4], row[5]);
  const FramePose target{frame.rotation * told.normalized().toRotationMatrix(),
                         point_in_root(frame, {row[0], row[1], row[2]})};
  const Evidence evidence = reach_pose(plan_, plan_.tools[command.action.part], target, branch.now);
  for (const std::size_t j : plan_.limits.parts[command.action.part].joints)
    note_speed(branch, j, branch.now[j] - branch.before[j]);
  return evidence;
}

// The slides carry the yaw axis; the root link's origin, of which the twist tells, swings about it.
// Turned by the yaw half way through the tick.
void Prediction::apply_body_twist(const Command& command, std::size_t index) {
  Branch& branch = branches_[index];
  const BaseLimits& base = plan_.limits.base;
  if (!base.present)  // nobody knows where it goes
    for (const std::size_t j : plan_.limits.parts[command.action.part].joints)
      branch.now[j] = unset;
  if (!base.present) return;
  const double share = command.gain(index) * plan_.period_s;
  const double turn = share * command.row[5];
  const double vx = share * command.row[0] - turn * base.yaw_axis[1];
  const double vy = share * command.row[1] + turn * base.yaw_axis[0];
  const double yaw = branch.now[base.joints[2]] + 0.5 * turn;
  const std::array<double, 3> changes{std::cos(yaw) * vx - std::sin(yaw) * vy,
                                      std::sin(yaw) * vx + std::cos(yaw) * vy, turn};
  for (std::size_t i = 0; i < changes.size(); ++i) {
    note_speed(branch, base.joints[i], changes[i]);
    branch.now[base.joints[i]] += changes[i];
  }
}

Evidence Prediction::check_finite() const {
  for (std::size_t i = 0; i < branch_count_; ++i)
    for (std::size_t j = 0; j < plan_.limits.joints.size(); ++j) {
      if ((commanded_ & only(j)) == 0) continue;
      const double sum = branches_[i].now[j] + branches_[i].speed[j];
      if (std::isfinite(sum)) continue;
      const JointLimits& joint = plan_.limits.joints[j];
      return at(broken_rule(code::unreachable, joint.name.view(), "a predicted position", sum), -1,
                plan_.limits.parts[joint.part].name);
    }
  return {};
}

}  // namespace fairlead
