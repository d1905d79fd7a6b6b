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
  const std::size_t part = command.action.part;
  const auto& joints = model_.limits.parts[part].joints;
  Motion6& left = branch.left[part];
  if (goals_add_up_ && left.hasNaN()) {
    for (const std::size_t j : joints) branch.now[j] = unset;
    return broken_rule(code::speed, "tool motion", lost_goal);
  }
  ToolWay way;
  const Evidence evidence = find_way(command, index, way);
  left = way.asked - way.share * way.asked;
  const double of_most = way.share / gain_block(command.modes, command.action.mode)->upper;
  for (const std::size_t j : joints) {
    const double change = way.after[j] - branch.before[j];
    note_speed(branch, j, change, of_most);
    branch.now[j] += change;
  }
  return evidence.ok() ? check_speed(branch, part, way.first_step, of_most) : evidence;
}

Evidence Prediction::find_way(const Command& command, std::size_t index, ToolWay& way) {
  Branch& branch = branches_[index];
  const std::size_t part = command.action.part;
  way.row = tick_motion(model_, branch.poses_before(), command.row);
  way.asked = goals_add_up_ ? one_after_other(branch.left[part], way.row) : way.row;
  way.share = gain(command, index);
  way.after = branch.before;
  return move_tool(model_, model_.tools[part], way.share * way.asked, branch.poses_before(),
                   branch.poses_now(), way.after, way.first_step);
}

// How much less or more the tool's joints may move in a row by where it starts, to first order. If
// they moved while a tick was held: the sum of what the start of each joint changes. If of earlier
// rows other shares may have happened: the sum of what the least of each of them changes, searched
// with the most of this row. Its least changes by its share of that, either way. Found before any
// branch goes on, so that all of them count it.
Evidence Prediction::note_other_ways(const Command& command) {
  if (!is_tool_motion(command.action.mode) || (rows_shared_ == 0 && !is_start_off_)) return {};
  const std::size_t part = command.action.part, most = share_count_ - 1;
  const auto& joints = model_.limits.parts[part].joints;
  ToolWay way;
  if (!find_way(command, most, way).ok()) return {};  // that branch will say so itself
  Evidence fault;
  Joints less{}, more{};
  const auto note = [&](const Joints& shift, Joints& below, Joints& above) {
    const Evidence evidence = find_other_way(command, branches_[most], way, shift, below, above);
    if (!evidence.ok()) fault = evidence;
  };
  for (const std::size_t moved : joints) {
    if (!is_start_off_ || start_off_[moved] == 0.0) continue;
    Joints shift{}, below{}, above{};
    shift[moved] = std::copysign(start_off_[moved], measured_.speed[moved]);
    note(shift, below, above);
    for (const std::size_t j : joints) {
      less[j] += larger(below[j], above[j]);
      more[j] += larger(below[j], above[j]);
    }
  }
  for (std::size_t i = 0; i < model_.limits.parts.size(); ++i) {
    if ((model_.part_joints[i] & model_.tools[part].movers) == 0) continue;
    for (std::size_t row = 0; row < rows_shared_; ++row) {
      Joints shift{};
      if (unequal_shares_[i].shift_to_least(row, shift)) note(shift, less, more);
    }
  }
  const Gain& gain = *gain_block(command.modes, command.action.mode);
  for (const std::size_t j : joints) {
    way_less_[j] = larger(less[j], gain.lower / gain.upper * more[j]);
    way_more_[j] = larger(more[j], gain.lower / gain.upper * less[j]);
  }
  return fault;
}

// Adds by how much less, or more, each joint moves from there.
Evidence Prediction::find_other_way(const Command& command, const Branch& branch,
                                    const ToolWay& way, const Joints& shift, Joints& less,
                                    Joints& more) const {
  const std::size_t part = command.action.part;
  Joints from = branch.before, first_step;
  for (std::size_t j = 0; j < from.size(); ++j) from[j] += shift[j];
  const FramePoses start(model_, from);
  FramePoses end = start;
  const Motion6 turned = tick_motion(model_, start, command.row) - way.row;
  Joints after = from;
  const Evidence evidence = move_tool(model_, model_.tools[part], way.share * (way.asked + turned),
                                      start, end, after, first_step);
  if (!evidence.ok()) return evidence;
  for (const std::size_t j : model_.limits.parts[part].joints) {
    const double change = after[j] - shift[j] - way.after[j];
    less[j] += larger(-change, 0.0);
    more[j] += larger(change, 0.0);
  }
  return {};
}

// G026: what a motion of the tool asks of a joint is no more than it may do, and it does no more
// than that already. `first_step`: where one straight step of least squares leads. Where that and
// the way found differ by much, the elbow may go either way, and as fast as either.
Evidence Prediction::check_speed(const Branch& branch, std::size_t part, const Joints& first_step,
                                 double of_most) const {
  for (const std::size_t j : model_.limits.parts[part].joints) {
    const JointLimits& joint = model_.limits.joints[j];
    const double from = came_from(branch, j);
    const auto [less, more] = speeds_off(j, of_most);
    double speed = 0.0;
    for (const double end : {branch.now[j], first_step[j]}) {
      const double way = (end - from) / model_.period_s;
      speed = larger(speed, larger(std::abs(way - less), std::abs(way + more)));
    }
    if (steps_ == 1) speed = larger(speed, std::abs(measured_speed(model_.limits, state_, j)));
    if (!(speed <= joint.velocity_limit))
      return above(code::speed, joint.name.view(), speed, joint.velocity_limit,
                   velocity_unit(joint.kind), joint.source.view());
  }
  return {};
}

void Prediction::widen_by_other_ways() {
  for (const std::size_t j : JointsIn(lagging_ | redundant_)) {
    start_off_[j] += larger(way_less_[j], way_more_[j]);
    const bool is_redundant = (redundant_ & only(j)) != 0;
    interval_.lowest[j] -= is_redundant ? start_off_[j] : way_less_[j];
    interval_.highest[j] += is_redundant ? start_off_[j] : way_more_[j];
  }
}

Evidence Prediction::apply_pose(const Command& command, Branch& branch) {
  Joints first_step;
  const Evidence evidence = solve_pose(command, branch, first_step);
  for (const std::size_t j : model_.limits.parts[command.action.part].joints)
    note_speed(branch, j, branch.now[j] - came_from(branch, j));
  return evidence.ok() ? check_speed(branch, command.action.part, first_step, 1.0) : evidence;
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
