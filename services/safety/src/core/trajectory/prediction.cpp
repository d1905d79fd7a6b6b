#include "core/trajectory/prediction.hpp"

#include <algorithm>
#include <cmath>

#include "core/chunk/state_check.hpp"
#include "core/geometry/distances.hpp"
#include "core/kinematics/robot_model.hpp"
#include "core/modes/commanded_motion.hpp"
#include "core/trajectory/braking.hpp"

namespace fairlead {

// Rows of one tick, of the chunk and its companions. A pose is reached for last: it depends on
// where other parts carry its own.
Evidence Prediction::apply_rows(const RowBefore& own, bool before) {
  Evidence fault;
  goals_add_up_ = goals_add_up(own, before);
  shared_by_.fill({});
  speeds_differ_ = false;
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
  for (Branch& branch : branches()) branch.poses_now().place(model_, branch.now);
  note_spread();
  note_base_speed();
  return fault.ok() ? check_speeds() : fault;
}

// What the base carries lags until all rests: of certified rows the fastest so far counts. Turned
// by as much as it may be off, its slides share their motion otherwise.
void Prediction::note_base_speed() {
  base_speed_before_ = forecast_only_ ? base_speed_ : std::max(base_speed_, base_speed_before_);
  base_speed_ = 0.0;
  if (!drives_base()) return;
  const BaseLimits& base = model_.limits.base;
  for (const Branch& branch : branches())
    for (const std::size_t j : JointsIn(moving_ & model_.base_joints)) {
      double speed = std::abs(branch.speed[j]);
      if (j != base.joints[2])
        speed +=
            turn_off() * std::hypot(branch.speed[base.joints[0]], branch.speed[base.joints[1]]);
      base_speed_ = std::max(base_speed_, speed / model_.limits.joints[j].velocity_limit);
    }
}

double Prediction::turn_off() const {
  if (!model_.limits.base.present) return 0.0;
  const std::size_t yaw = model_.limits.base.joints[2];
  double off = is_start_off_ ? start_off_[yaw] : 0.0;
  if ((coasting_ & only(yaw)) != 0)
    for (const Branch& branch : branches())
      off = std::max(off, std::abs(branch.now[yaw] - measured_.now[yaw]));
  return off;
}

double Prediction::interval_width(std::size_t part) const {
  const double reach = model_.tools[part].reach;
  double widest = 0.0;
  for (const std::size_t j : model_.limits.parts[part].joints) {
    const double width = interval_before_.highest[j] - interval_before_.lowest[j];
    const bool slides = model_.limits.joints[j].kind == JointKind::prismatic;
    if (!slides)
      widest = std::max(widest, width);
    else if (reach > 0.0)
      widest = std::max(widest, width / reach);
  }
  return widest;
}

Evidence Prediction::advance() {
  row_ = next_row_++;
  if (gain_parts_.size() > max_gains)
    return above(code::unreachable, "parts", static_cast<double>(gain_parts_.size()),
                 static_cast<double>(max_gains), "1", "parts with a gain that move at once");
  ++steps_;
  interval_before_ = interval_;
  for (Branch& branch : branches()) branch.begin_row();
  settle_uncommanded();
  way_less_.fill(0.0);
  way_more_.fill(0.0);
  Evidence fault = apply_rows(RowBefore{&chunk_, row_}, false);
  if (is_start_off_ || shares_can_differ()) widen_by_other_ways();
  has_earlier_target_ = 0;  // what rows command from here on is where the branches are
  if (steps_ > 1)           // a target was reached from wherever it was
    for (const std::size_t j : JointsIn(moving_ & ~lagging_ & ~redundant_)) start_off_[j] = 0.0;
  return fault.ok() ? check_finite() : fault;
}

// Joints that the rows of the `step`-th tick command.
JointSet Prediction::commanded_in(std::size_t step) const {
  JointSet joints = commanded_;
  for (const Companion& companion : companions_)
    if (companion.chunk != nullptr && companion.row + step - 1 < companion.end_row)
      for (const ActionPart& action : companion.chunk->parts) joints |= moved_by(model_, action);
  return joints;
}

// What nothing commands brakes, and is where that ends from this row on. Where others hold it
// is that one row later: so the chunk's rows meet it where it was and where it comes to rest. What
// only its positions say to move may stand where it is all the time.
void Prediction::settle_uncommanded() {
  const JointSet commanded = commanded_in(steps_);
  for (std::size_t i = 0; i < branch_count_; ++i) {
    Branch& branch = branches_[i];
    const bool holds = i >= branch_count_ - holding_count_;
    if (holds && steps_ == 1) continue;
    const JointSet left = moving_ & ~(holds ? commanded_ | perhaps_still_ : commanded);
    const Braking braking(model_, branch, left, lagging());
    for (const std::size_t j : JointsIn(left)) {
      branch.now[j] = braking.end()[j];
      branch.speed[j] = 0.0;
    }
  }
}

// Says what is the first fault, and goes on: another claim's row may be at fault for one part, or
// in one branch, and still move the others.
Evidence Prediction::apply_row(const ActionChunk& chunk, std::size_t row, bool own, bool poses,
                               std::size_t branch_count) {
  Evidence fault;
  for (const ActionPart& action : chunk.parts) {
    if (is_pose(action) != poses) continue;
    const ModeLimits& modes =
        own ? claim_.modes[action.part] : model_.limits.parts[action.part].modes;
    const Command command{action, modes, row_of(action, row, model_.limits)};
    shared_by_[action.part] = {gain_block(modes, action.mode),
                               goals_add_up_ && is_tool_motion(action.mode)};
    const auto note = [&](const Evidence& evidence) {
      if (fault.ok() && !evidence.ok()) fault = of(evidence, model_.limits.parts[action.part].name);
    };
    const Evidence other_ways = note_other_ways(command);
    for (std::size_t i = 0; i < branch_count; ++i) note(apply(command, i));
    note(other_ways);
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
// the first row it may still be as fast as it is measured, if that is the same way, or already as
// slow as commanded; and a target is reached from wherever the hold before has left the joint.
void Prediction::note_speed(Branch& branch, std::size_t joint, double change,
                            double of_most) const {
  const double limit = model_.fastest[joint];
  double commanded = change / model_.period_s;
  commanded += std::copysign(std::min(creep(joint), std::abs(commanded)), commanded);
  double& speed = branch.speed[joint];
  speed = std::clamp(commanded, -limit, limit);
  const auto [less, more] = speeds_off(joint, of_most);
  if (steps_ != 1 && less == 0.0 && more == 0.0) return;
  const double lower = std::clamp(commanded - less, -limit, limit);
  const double upper = std::clamp(commanded + more, -limit, limit);
  const double slow = speed < 0.0 ? upper : lower;
  const double measured = measured_speed(model_.limits, state_, joint);
  double fast = speed < 0.0 ? lower : upper;
  if (steps_ == 1 && (speed > 0.0 ? measured > fast : speed < 0.0 && measured < fast))
    fast = measured;
  if (fast == slow) return;
  branch.slower[joint] = slow;
  branch.slowing |= only(joint);
  speed = fast;
}

// Whether the first row's target, or a goal from before the hold, is reached from wherever that has
// left the joint.
bool Prediction::reaches_goal(std::size_t joint) const {
  return steps_ == 1 && (goals_add_up_ || (lagging_ & only(joint)) == 0);
}

// How much less or more speed a joint may have by where the newest row starts: a tool's joint goes
// another way from there, or reaches a goal from there. For less than the most of a row that start
// may be on either side.
std::pair<double, double> Prediction::speeds_off(std::size_t joint, double of_most) const {
  double less = way_less_[joint], more = way_more_[joint];
  if (of_most < 1.0) less = more = of_most * larger(less, more);
  const double goal = goal_off(joint);
  return {(less + goal) / model_.period_s, (more + goal) / model_.period_s};
}

double Prediction::goal_off(std::size_t joint) const {
  return reaches_goal(joint) ? start_off_[joint] : 0.0;
}

// How much faster a held joint may reach its goal that was slow enough to count as standing when it
// was measured, and may have gone on. A row that moves it less moves it by less: one that tells it
// to stay may not be refused for noise.
double Prediction::creep(std::size_t joint) const {
  const bool stands = (held_ & only(joint)) != 0 && measured_.speed[joint] == 0.0;
  return stands && reaches_goal(joint) ? possible_speed(state_, joint) : 0.0;
}

// The joint's target in the row before, if it had one: what is measured may lag behind that.
double Prediction::came_from(const Branch& branch, std::size_t joint) const {
  return (has_earlier_target_ & only(joint)) != 0 ? earlier_targets_[joint] : branch.before[joint];
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
  for (const std::size_t j : JointsIn(moved_by(model_, command.action))) {
    const double commanded = commanded_velocity(model_.limits, command.row, j, branch.before);
    const double change = gain(command, index) * commanded * model_.period_s;
    note_speed(branch, j, change);
    branch.now[j] += change;
  }
}

// The slides carry the yaw axis; the root link's origin, of which the twist tells, swings about it.
// Turned by the yaw half way through the tick.
void Prediction::apply_body_twist(const Command& command, std::size_t index) {
  Branch& branch = branches_[index];
  const BaseLimits& base = model_.limits.base;
  if (!base.present)  // nobody knows where it goes
    for (const std::size_t j : model_.limits.parts[command.action.part].joints)
      branch.now[j] = unset;
  if (!base.present) return;
  const double share = gain(command, index) * model_.period_s;
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
        const JointLimits& joint = model_.limits.joints[j];
        return of(broken_rule(code::unreachable, joint.name.view(), "a finite place where it leads",
                              value),
                  model_.limits.parts[joint.part].name);
      }
  return {};
}

}  // namespace fairlead
