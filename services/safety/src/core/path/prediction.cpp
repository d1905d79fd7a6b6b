#include "prediction.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "command_kind.hpp"
#include "joint_set.hpp"
#include "tool_motion.hpp"

namespace fairlead {
namespace {

// How far the way of a row of a tool may bend: what least squares find for it from where the joints
// are and where it ends, joint by joint, in velocity limits times the tick. Where it bends more,
// the elbow may go one way or another: two ways to reckon then differ by 0.1 rad and more, and
// beyond 5 by anything. Full scale on every axis bends by 2.6 at most where robots work,
// demonstrations by less than 0.1. Later rows begin where the ones before them are only predicted
// to end.
constexpr double most_bend = 3.0;
constexpr double most_bend_later = 1.5;

Motion6 six_of(const Setpoint& row) {
  Motion6 numbers;
  numbers << row[0], row[1], row[2], row[3], row[4], row[5];
  return numbers;
}

}  // namespace

double Prediction::gain(const Command& command, std::size_t branch) const {
  const Gain* gain = gain_block(command.modes, command.action.mode);
  if (gain == nullptr) return unset;  // GCOVR_EXCL_BR_LINE: asked of modes that have one
  return ((branch >> gain_bit_[command.action.part]) & 1U) == 0 ? gain->lower : gain->upper;
}

// Rows of one tick, of the chunk and its companions. A pose is reached for last: it depends on
// where other parts carry its own.
Evidence Prediction::apply_rows(const RowBefore& own, bool before) {
  Evidence fault;
  for (const bool poses : {false, true}) {
    if (own.chunk != nullptr) {
      const Evidence evidence = apply_row(*own.chunk, own.row, true, poses, branch_count_);
      if (fault.ok()) fault = evidence;
    }
    for (const Companion& companion : companions_) {
      if (before && companion.before.chunk != nullptr)
        (void)apply_row(*companion.before.chunk, companion.before.row, false, poses, branch_count_);
      const std::size_t row = companion.row + steps_ - 1;  // of the tick that `own` acts in
      if (!before && companion.chunk != nullptr && row < companion.end_row)
        (void)apply_row(*companion.chunk, row, false, poses, branch_count_ - holding_count_);
    }
  }
  for (Branch& branch : branches()) branch.poses_now().place(plan_, branch.now);
  note_spread();
  return fault;
}

// Which share of a row happens may be another one in the next: each goes on from the furthest that
// any of those before it can have got to.
void Prediction::note_spread() {
  for (const std::size_t j : JointsIn(moving_)) {
    const bool adds_up = (lagging_ & only(j)) != 0;
    double lowest = std::numeric_limits<double>::infinity(), highest = -lowest;
    for (const Branch& branch : branches()) {
      const double now = branch.now[j], before = branch.before[j];
      lowest = std::min(lowest, adds_up ? now + (spread_.lowest[j] - before) : now);
      highest = std::max(highest, adds_up ? now + (spread_.highest[j] - before) : now);
    }
    spread_.lowest[j] = lowest;
    spread_.highest[j] = highest;
  }
}

double Prediction::doubt(std::size_t part) const {
  double widest = 0.0;
  for (const std::size_t j : plan_.limits.parts[part].joints)
    widest = std::max(widest, spread_before_.highest[j] - spread_before_.lowest[j]);
  return widest;
}

Evidence Prediction::advance() {
  row_ = next_row_++;
  if (gain_parts_.size() > max_gains)
    return above(code::unreachable, "parts", static_cast<double>(gain_parts_.size()),
                 static_cast<double>(max_gains), "parts with a gain that move at once");
  ++steps_;
  spread_before_ = spread_;
  for (Branch& branch : branches()) branch.begin_row();
  Evidence fault = apply_rows(RowBefore{&chunk_, row_}, false);
  targets_told_ = 0;  // what rows tell from here on is where the branches are
  has_settled_ = steps_ > 1 && leads_nowhere();
  return fault.ok() ? check_finite() : fault;
}

// Says what is the first fault, and goes on: another claim's row may be at fault for one part, or
// in one branch, and still move the others.
Evidence Prediction::apply_row(const ActionChunk& chunk, std::size_t row, bool own, bool poses,
                               std::size_t branch_count) {
  Evidence fault;
  for (const ActionPart& action : chunk.parts) {
    if (is_pose(action) != poses) continue;
    const ModeLimits& modes =
        own ? claim_.modes[action.part] : plan_.limits.parts[action.part].modes;
    const Command command{action, modes, row_of(action, row, plan_.limits)};
    for (std::size_t i = 0; i < branch_count; ++i) {
      const Evidence evidence = apply(command, i);
      if (fault.ok() && !evidence.ok()) fault = of(evidence, plan_.limits.parts[action.part].name);
    }
  }
  return fault;
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

// No joint is faster than its limit: of a row that asks for more, the controller makes less. In
// the first row it may still be as fast as it is measured, if that is the same way.
void Prediction::note_speed(Branch& branch, std::size_t joint, double change) const {
  const double limit = plan_.fastest[joint];
  const double told = change / plan_.period_s;
  double& speed = branch.speed[joint];
  speed = std::clamp(told, -limit, limit);
  if (steps_ != 1) return;
  if (speed > 0.0) speed = std::max(speed, state_.velocities[joint]);
  if (speed < 0.0) speed = std::min(speed, state_.velocities[joint]);
}

// Where the row before told the joint to be, if it did: what is measured may lag behind that.
double Prediction::came_from(const Branch& branch, std::size_t joint) const {
  return (targets_told_ & only(joint)) != 0 ? told_[joint] : branch.before[joint];
}

// A target is reached; how fast, says the row before it.
void Prediction::apply_targets(const Command& command, Branch& branch) {
  for (const std::uint8_t j : command.action.active) {
    const double target = command.row[j];
    note_speed(branch, j, target - came_from(branch, j));
    branch.now[j] = target;
  }
}

void Prediction::apply_velocities(const Command& command, std::size_t index) {
  Branch& branch = branches_[index];
  for (const std::size_t j : JointsIn(moved_by(plan_, command.action))) {
    const double told = told_velocity(plan_.limits, command.row, j, branch.before);
    const double change = gain(command, index) * told * plan_.period_s;
    note_speed(branch, j, change);
    branch.now[j] += change;
  }
}

void Prediction::apply_torques(const Command& command, Branch& branch) {
  for (const std::uint8_t j : command.action.active) branch.speed[j] = state_.velocities[j];
}

// A tool that is told to stay, does; least squares and rounding would make 1e-17 rad of that. Not
// so in the first row: there the least motion decides whether what is measured of a joint counts as
// its speed, and what is reckoned with care is not to be passed over.
bool Prediction::stays(const Motion6& told) const {
  return steps_ != 1 && (told.array() == 0.0).all();
}

// From the configuration before the row, whatever other parts do in it.
Evidence Prediction::apply_tool_motion(const Command& command, std::size_t index) {
  Branch& branch = branches_[index];
  const bool twist = command.action.mode == static_cast<std::uint8_t>(Mode::cartesian_twist);
  const double share = gain(command, index) * (twist ? plan_.period_s : 1.0);
  const Motion6 told = share * six_of(command.row);
  if (stays(told)) {
    for (const std::size_t j : plan_.limits.parts[command.action.part].joints)
      branch.speed[j] = 0.0;
    return {};
  }
  const Eigen::Matrix3d axes =
      link_pose(plan_, command.action.frame_id, branch.poses_before()).rotation;
  Motion6 motion;
  motion << axes * told.head<3>(), axes * told.tail<3>();
  Joints after = branch.before;
  Joints straight;
  const Evidence evidence = move_tool(plan_, plan_.tools[command.action.part], motion,
                                      branch.poses_before(), branch.poses_now(), after, straight);
  for (const std::size_t j : plan_.limits.parts[command.action.part].joints) {
    const double change = after[j] - branch.before[j];
    note_speed(branch, j, change);
    branch.now[j] += change;
  }
  return evidence.ok() ? check_bend(command.action.part, straight, after) : evidence;
}

Evidence Prediction::check_bend(std::size_t part, const Joints& straight, const Joints& end) const {
  const double most = steps_ == 1 ? most_bend : most_bend_later;
  for (const std::size_t j : plan_.limits.parts[part].joints) {
    const JointLimits& joint = plan_.limits.joints[j];
    const double bend = std::abs(end[j] - straight[j]) / plan_.period_s;
    const double limit = most * joint.velocity_limit;
    if (!(bend <= limit))
      return above(code::unreachable, joint.name.view(), bend, limit,
                   "a way that bends no further than its joints can make up for");
  }
  return {};
}

Evidence Prediction::apply_pose(const Command& command, Branch& branch) {
  Joints straight;
  const Evidence evidence = reach(command, branch, straight);
  for (const std::size_t j : plan_.limits.parts[command.action.part].joints)
    note_speed(branch, j, branch.now[j] - came_from(branch, j));
  return evidence.ok() ? check_bend(command.action.part, straight, branch.now) : evidence;
}

// From where the other parts of the row carry its own.
Evidence Prediction::reach(const Command& command, Branch& branch, Joints& straight) const {
  branch.poses_now().place(plan_, branch.now);
  const FramePose frame = link_pose(plan_, command.action.frame_id, branch.poses_now());
  const Setpoint& row = command.row;
  const Eigen::Quaterniond told(row[6], row[3], row[4], row[5]);
  const FramePose target{frame.rotation * told.normalized().toRotationMatrix(),
                         point_in_root(frame, {row[0], row[1], row[2]})};
  return reach_pose(plan_, plan_.tools[command.action.part], target, branch.poses_now(), branch.now,
                    straight);
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
  const double share = gain(command, index) * plan_.period_s;
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
  for (const Branch& branch : branches())
    for (const std::size_t j : JointsIn(commanded_))
      for (const double value : {branch.now[j], branch.speed[j]}) {
        if (std::isfinite(value)) continue;
        const JointLimits& joint = plan_.limits.joints[j];
        return of(broken_rule(code::unreachable, joint.name.view(), "a predicted position", value),
                  plan_.limits.parts[joint.part].name);
      }
  return {};
}

}  // namespace fairlead
