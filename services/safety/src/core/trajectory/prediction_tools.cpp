// What a motion or a pose of a tool makes of the joints, and how fast (G026, G030).

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/chunk/state_check.hpp"
#include "core/geometry/distances.hpp"
#include "core/kinematics/inverse_kinematics.hpp"
#include "core/modes/commanded_motion.hpp"
#include "core/trajectory/prediction.hpp"

namespace fairlead {
namespace {

// A tool whose composite switch is up goes on from its last goal.
constexpr std::string_view lost_goal = "a held tick, after a lost state or row";

}  // namespace

double Prediction::gain(const Command& command, std::size_t branch) const {
  const Gain* gain = gain_block(command.modes, command.action.mode);
  if (gain == nullptr) return unset;  // GCOVR_EXCL_BR_LINE: asked of modes that have one
  const std::size_t ends = branch % share_count_;
  if (ends == 0) return 0.5 * (gain->lower + gain->upper);
  return (((ends - 1) >> gain_bit_[command.action.part]) & 1U) == 0 ? gain->lower : gain->upper;
}

// Where the composite switch is up, a controller takes the motions of a tool from its last goal on,
// not from where the tool is: what it has not made of one is left for the next.
bool Prediction::is_switched_up(const ActionChunk& chunk, std::size_t row) const {
  for (const ActionPart& action : chunk.parts)
    if (action.mode == static_cast<std::uint8_t>(Mode::composite_mode) &&
        !(row_of(action, row, model_.limits)[0] < 0.0))
      return true;
  return false;
}

bool Prediction::goals_add_up(const RowBefore& own, bool before) const {
  if (own.chunk != nullptr && is_switched_up(*own.chunk, own.row)) return true;
  for (const Companion& companion : companions_) {
    RowBefore row = companion.before;
    if (!before) {
      row = RowBefore{companion.chunk, companion.row + steps_ - 1};
      if (row.row >= companion.end_row) continue;
    }
    if (row.chunk != nullptr && is_switched_up(*row.chunk, row.row)) return true;
  }
  return false;
}

// From the configuration before the row, whatever other parts do in it.
Evidence Prediction::apply_tool_motion(const Command& command, std::size_t index) {
  Branch& branch = branches_[index];
  const auto& joints = model_.limits.parts[command.action.part].joints;
  Motion6 asked = tick_motion(model_, branch.poses_before(), command.row);
  Motion6& left = branch.left[command.action.part];
  if (goals_add_up_) {
    if (left.hasNaN()) {
      for (const std::size_t j : joints) branch.now[j] = unset;
      return broken_rule(code::speed, "tool motion", lost_goal);
    }
    asked = one_after_other(left, asked);
  }
  const double share = gain(command, index);
  const Motion6 motion = share * asked;
  left = asked - motion;
  Joints after = branch.before;
  Joints first_step;
  Evidence evidence = move_tool(model_, model_.tools[command.action.part], motion,
                                branch.poses_before(), branch.poses_now(), after, first_step);
  if (evidence.ok()) evidence = note_other_ways(command.action.part, motion, index, after);
  for (const std::size_t j : joints) {
    const double change = after[j] - branch.before[j];
    note_speed(branch, j, change);
    branch.now[j] += change;
  }
  return evidence.ok() ? check_speed(branch, command.action.part, first_step) : evidence;
}

// From where each joint may really be, the tool's joints go other ways: by as much, all together,
// as the ways differ of one joint at a time. And where less than the most has happened of the rows
// before, by as much as where the least has.
Evidence Prediction::note_other_ways(std::size_t part, const Motion6& motion, std::size_t index,
                                     const Joints& after) {
  const Branch& branch = branches_[index];
  const auto& joints = model_.limits.parts[part].joints;
  Joints differ{};
  const auto note = [&](const Joints& from, FramePoses start) {
    Joints other = from, first_step;
    FramePoses end = start;
    const Evidence evidence =
        move_tool(model_, model_.tools[part], motion, start, end, other, first_step);
    for (const std::size_t j : joints)
      differ[j] += std::abs((other[j] - from[j]) - (after[j] - branch.before[j]));
    return evidence;
  };
  Evidence evidence;
  for (const std::size_t moved : joints) {
    if (!is_start_off_ || start_off_[moved] == 0.0 || !evidence.ok()) continue;
    Joints from = branch.before;
    from[moved] += std::copysign(start_off_[moved], measured_.speed[moved]);
    FramePoses start = branch.poses_before();
    start.place_chain(model_, model_.tools[part], from);
    evidence = note(from, start);
  }
  if (rows_shared_ > 0 && index + 1 == share_count_ && evidence.ok())
    evidence = note(branches_[1].before, branches_[1].poses_before());
  for (const std::size_t j : joints) way_off_[j] = larger(way_off_[j], differ[j]);
  return evidence;
}

// G026: what a motion of the tool asks of a joint is no more than it may do, and it does no more
// than that already. `first_step`: where one straight step of least squares leads. Where that and
// the way found differ by much, the elbow may go either way, and as fast as either.
Evidence Prediction::check_speed(const Branch& branch, std::size_t part,
                                 const Joints& first_step) const {
  for (const std::size_t j : model_.limits.parts[part].joints) {
    const JointLimits& joint = model_.limits.joints[j];
    const double from = came_from(branch, j);
    double speed = larger(std::abs(branch.now[j] - from), std::abs(first_step[j] - from));
    speed = speed / model_.period_s + speed_off(j);
    if (steps_ == 1) speed = larger(speed, std::abs(measured_speed(model_.limits, state_, j)));
    if (!(speed <= joint.velocity_limit))
      return above(code::speed, joint.name.view(), speed, joint.velocity_limit,
                   velocity_unit(joint.kind), joint.source.view());
  }
  return {};
}

void Prediction::widen_by_other_ways() {
  for (const std::size_t j : JointsIn(lagging_ | redundant_)) {
    start_off_[j] += way_off_[j];
    const double off = (redundant_ & only(j)) != 0 ? start_off_[j] : way_off_[j];
    interval_.lowest[j] -= off;
    interval_.highest[j] += off;
  }
}

Evidence Prediction::apply_pose(const Command& command, Branch& branch) {
  Joints first_step;
  const Evidence evidence = solve_pose(command, branch, first_step);
  for (const std::size_t j : model_.limits.parts[command.action.part].joints)
    note_speed(branch, j, branch.now[j] - came_from(branch, j));
  return evidence.ok() ? check_speed(branch, command.action.part, first_step) : evidence;
}

// From where the other parts of the row carry its own.
Evidence Prediction::solve_pose(const Command& command, Branch& branch, Joints& first_step) const {
  branch.poses_now().place(model_, branch.now);
  const Pose frame =
      pose_at(model_.places[link_of(model_.limits, command.row)], branch.poses_now());
  const Pose commanded = pose_of(command.row);
  const Pose target{frame.rotation * commanded.rotation, point_in_root(frame, commanded.position)};
  return reach_pose(model_, model_.tools[command.action.part], target, branch.poses_now(),
                    branch.now, first_step);
}

}  // namespace fairlead
