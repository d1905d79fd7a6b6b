// What the prediction starts from: the measured state, the rows that acted last, and the branches.

#include <algorithm>
#include <cmath>

#include "core/chunk/state_check.hpp"
#include "core/kinematics/inverse_kinematics.hpp"
#include "core/kinematics/robot_model.hpp"
#include "core/modes/commanded_motion.hpp"
#include "core/trajectory/prediction.hpp"

namespace fairlead {

Branch& Branch::operator=(const Branch& other) {
  now = other.now;
  speed = other.speed;
  before = other.before;
  left = other.left;
  poses_now() = other.poses_now();
  return *this;
}

Branch Branch::slowed() const {
  Branch other = *this;
  other.poses[other.newest ^ 1U] = poses_before();
  for (const std::size_t j : JointsIn(slowing)) other.speed[j] = slower[j];
  return other;
}

Prediction::Prediction(const RobotModel& model, const ClaimLimits& claim,
                       const MeasuredState& state, const ActionChunk& chunk, std::size_t first_row,
                       const RowBefore& before, Companions companions)
    : model_(model),
      claim_(claim),
      state_(state),
      chunk_(chunk),
      companions_(companions),
      next_row_(first_row) {
  include(chunk, commanded_);
  moving_ |= commanded_;
  if (before.chunk != nullptr) include(*before.chunk, moving_);
  include_companions();
  start_still(before.memories);
  if (!before.measured) {
    start_count_ = branch_count_;
    for (Branch& branch : branches()) branch.begin_row();
    held_ = held_in(before);
    for (Branch& branch : branches())
      for (const std::size_t j : JointsIn(held_))
        branch.now[j] += 0.5 * measured_.speed[j] * model_.period_s;
    (void)apply_rows(before, true);
    note_new_goals(before);
    widen_start();
    return;
  }
  if (before.chunk != nullptr) note_targets(*before.chunk, before.row);
  for (const Companion& companion : companions)
    if (companion.before.chunk != nullptr)
      note_targets(*companion.before.chunk, companion.before.row);
}

// Joints that rows command from the next tick on, but none in the one that runs: they hold in
// it, and were measured to move when it began. Until it ends they may have stopped at once, or gone
// on: the branches start half way between.
JointSet Prediction::held_in(const RowBefore& before) const {
  JointSet joints = commanded_in(1);
  const auto leave_out = [&](const RowBefore& row) {
    if (row.chunk == nullptr) return;
    for (const ActionPart& action : row.chunk->parts) joints &= ~moved_by(model_, action);
  };
  leave_out(before);
  for (const Companion& companion : companions_) leave_out(companion.before);
  return joints & moving_;
}

// Half of what it may go on in a tick. An arm of more than six joints that reaches for a pose keeps
// some of that: it may show in any of its joints, but is no longer than all of it together.
double Prediction::held_off(std::size_t joint) const {
  const auto off = [&](std::size_t j) { return 0.5 * measured_.speed[j] * model_.period_s; };
  if ((redundant_ & only(joint)) == 0) return std::abs(off(joint));
  double sum = 0.0;
  for (const std::size_t j : model_.limits.parts[model_.limits.joints[joint].part].joints)
    sum += off(j) * off(j);
  return std::sqrt(sum);
}

void Prediction::widen_start() {
  for (const std::size_t j : JointsIn(held_)) {
    const double off = held_off(j);
    start_off_[j] = off;
    is_start_off_ |= off > 0.0;
    interval_.lowest[j] -= off;
    interval_.highest[j] += off;
  }
}

void Prediction::include_companions() {
  JointSet others = 0;
  for (const Companion& companion : companions_) {
    if (companion.chunk != nullptr) include(*companion.chunk, others);
    if (companion.before.chunk != nullptr) include(*companion.before.chunk, moving_);
  }
  moving_ |= others;
}

// Another claim may be stopped, or its rows not arrive: then its parts hold from now on. And what
// coasts may be where it is measured for a while, or come to rest at once.
void Prediction::include_holding() {
  share_count_ = branch_count_;
  if ((moving_ & ~commanded_ & model_.tree_joints) == 0) return;
  holding_count_ = branch_count_;
  branch_count_ *= 2;
}

void Prediction::only_forecast() {
  branch_count_ = share_count_ = 1;
  forecast_only_ = true;
  is_start_off_ = false;
  rows_shared_ = 0;
  holding_count_ = 0;
  interval_ = {branches_.front().now, branches_.front().now};
}

// A joint that nothing commands stays; one that is measured to move brakes from there. A gripper's
// declares no deceleration: its fingers stay where they are measured.
void Prediction::start_still(const PartMemories* memories) {
  measured_.now = state_.positions;
  measured_.speed.fill(0.0);
  for (std::size_t j = 0; j < model_.limits.joints.size(); ++j) {
    const JointLimits& joint = model_.limits.joints[j];
    const double speed = measured_speed(model_.limits, state_, j);
    if (std::isnan(joint.acceleration_limit) || std::abs(speed) < joint.standstill_velocity)
      continue;
    measured_.speed[j] = speed;
    moving_ |= only(j);
    coasting_ |= only(j) & ~commanded_;
    if (std::abs(state_.velocities[j]) < joint.standstill_velocity) perhaps_still_ |= only(j);
  }
  include_holding();
  measured_.before = interval_.lowest = interval_.highest = measured_.now;
  measured_.poses_now().place(model_, measured_.now);
  note_left(memories);
  for (Branch& branch : branches()) branch = measured_;
  note_base_speed();
}

// How far each tool is from the last goal of its controller.
void Prediction::note_left(const PartMemories* memories) {
  for (std::size_t i = 0; i < model_.limits.parts.size(); ++i) {
    Motion6& left = measured_.left[i];
    left.setZero();
    if (memories == nullptr || !model_.tools[i].present) continue;
    const std::optional<Pose>& goal = (*memories)[i].goal;
    left.setConstant(unset);
    if (goal) left = motion_between(pose_at(model_.tools[i].place, measured_.poses_now()), *goal);
  }
}

// A tool that has no row in the tick that runs holds: its goal is where it was when that began, if
// anybody knew it then. One that has a row of another kind than a motion has none.
void Prediction::note_new_goals(const RowBefore& before) {
  std::array<const ActionPart*, max_parts> acting{};
  const auto note = [&](const RowBefore& row) {
    if (row.chunk == nullptr) return;
    for (const ActionPart& action : row.chunk->parts) acting[action.part] = &action;
  };
  note(before);
  for (const Companion& companion : companions_) note(companion.before);
  for (std::size_t i = 0; i < model_.limits.parts.size(); ++i) {
    const ModelTool& tool = model_.tools[i];
    if (!tool.present || (acting[i] != nullptr && is_tool_motion(acting[i]->mode))) continue;
    for (Branch& branch : branches()) {
      if (acting[i] == nullptr && !branch.left[i].hasNaN())
        branch.left[i] = motion_between(pose_at(tool.place, branch.poses_now()),
                                        pose_at(tool.place, measured_.poses_now()));
      else
        branch.left[i].setConstant(unset);
    }
  }
}

// A controller takes time to turn a motion around, and may keep up another beside it. A joint that
// has a target brakes at once if that is behind it.
void Prediction::coast_one_tick(Branch& branch) const {
  branch.begin_row();
  for (const std::size_t j : JointsIn(lagging_)) branch.now[j] += branch.speed[j] * model_.period_s;
  branch.poses_now().place(model_, branch.now);
}

bool Prediction::is_coasting(const Branch& branch) const {
  for (const std::size_t j : JointsIn(commanded_ | lagging_))
    if (branch.speed[j] != 0.0) return true;
  return false;
}

void Prediction::include(const ActionChunk& chunk, JointSet& joints) {
  for (const ActionPart& action : chunk.parts) {
    joints |= moved_by(model_, action);
    const PartLimits& part = model_.limits.parts[action.part];
    const Gain* gain = gain_block(part.modes, action.mode);
    if (is_pose(action) && part.joints.size() > 6) redundant_ |= moved_by(model_, action);
    if (gain != nullptr) lagging_ |= moved_by(model_, action);
    if (gain == nullptr || gain->lower == gain->upper) continue;
    add_branches(action.part);
    if (!is_joint_mode(action.mode)) guessed_ |= moved_by(model_, action);
  }
}

// A part that moves no link meets no other: it goes along with the first part that does.
void Prediction::add_branches(std::size_t part) {
  const bool moves_links = (model_.part_joints[part] & model_.tree_joints) != 0;
  if (moves_links && !gain_parts_.contains(part)) {
    gain_bit_[part] = static_cast<std::uint8_t>(gain_parts_.size());
    (void)gain_parts_.push_back(part);
  }
  const std::size_t ends = std::clamp<std::size_t>(gain_parts_.size(), 1, max_gains);
  branch_count_ = 1 + (std::size_t{1} << ends);
}

// The pose of the row before: where its servo is going, whatever is measured.
void Prediction::note_pose(const ActionPart& action, std::size_t row) {
  Branch target = branches().front();
  Joints first_step;
  const Command command{action, model_.limits.parts[action.part].modes,
                        row_of(action, row, model_.limits)};
  if (!solve_pose(command, target, first_step).ok()) return;
  for (const std::size_t j : model_.limits.parts[action.part].joints) {
    earlier_targets_[j] = target.now[j];
    has_earlier_target_ |= only(j);
  }
}

void Prediction::note_targets(const ActionChunk& chunk, std::size_t row) {
  for (const ActionPart& action : chunk.parts) {
    if (is_pose(action)) note_pose(action, row);
    if (!is_target(static_cast<Mode>(action.mode))) continue;
    const Setpoint targets = row_of(action, row, model_.limits);
    for (const std::uint8_t j : action.active) {
      earlier_targets_[j] = targets[j];
      has_earlier_target_ |= only(j);
    }
  }
}

std::optional<Joints> Prediction::last_targets() const {
  if (has_earlier_target_ == 0) return std::nullopt;
  Joints targets = measured_.now;
  for (const std::size_t j : JointsIn(has_earlier_target_)) targets[j] = earlier_targets_[j];
  return targets;
}

}  // namespace fairlead
