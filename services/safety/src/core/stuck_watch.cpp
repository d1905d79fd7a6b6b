#include "stuck_watch.hpp"

#include <algorithm>

#include "fairlead_safety/mode_blocks.hpp"
#include "told_motion.hpp"

namespace fairlead {
namespace {

bool changed(const MotionView& view, std::size_t joint) {
  return std::abs(change_of(view, joint)) > view.limits.joints[joint].encoder_step;
}

// A dead band that is no number is none.
bool beyond(double motion, double dead_band) { return !(motion <= dead_band); }

bool moves_joint(const MotionView& view, std::size_t j) {
  if (!view.now.commands(j)) return false;
  const JointLimits& joint = view.limits.joints[j];
  switch (static_cast<Mode>(view.mode())) {
    case Mode::joint_velocity:
      return beyond(std::abs(view.now[j]) * view.period_s(), joint.dead_band);
    case Mode::joint_position:
    case Mode::dex_hand_joint:
      return beyond(std::abs(turned_by(joint, view.state.positions[j], view.now[j])),
                    joint.dead_band);
    default:
      return false;  // a torque says nothing about motion
  }
}

// The dead band of a part told how its tool or the whole base is to move: of its joints' the
// largest, read as metres for the one half and as radians for the other.
double part_dead_band(const MotionView& view) {
  double dead_band = 0.0;
  for (const std::size_t j : view.part().joints)
    dead_band = std::max(dead_band, view.limits.joints[j].dead_band);
  return dead_band;
}

bool moves_part(const MotionView& view) {
  const double dead_band = part_dead_band(view);
  if (view.mode() == static_cast<std::uint8_t>(Mode::cartesian_pose)) {
    const PoseError error = pose_error(view);
    return beyond(error.distance, dead_band) || beyond(error.angle, dead_band);
  }
  const CartesianLimits* mode = norm_block(view.modes, view.mode());
  if (mode == nullptr || !(mode->gain.lower > 0.0)) return false;
  const bool per_tick = view.mode() == static_cast<std::uint8_t>(Mode::cartesian_delta);
  const double share = mode->gain.lower * (per_tick ? 1.0 : view.period_s());
  const Twist told = halves(view.now);
  return beyond(share * told.linear.norm(), dead_band) ||
         beyond(share * told.angular.norm(), dead_band);
}

Evidence stuck(const MotionView& view, std::size_t joint, std::string_view rule) {
  const JointLimits& limits = view.limits.joints[joint];
  return below(code::stuck, limits.name.view(), std::abs(change_of(view, joint)),
               limits.encoder_step, rule);
}

}  // namespace

Evidence StuckWatch::after_joint_row(const MotionView& view) {
  for (const std::size_t j : view.part().joints) {
    const bool rests = moves_joint(view, j) && !changed(view, j);
    joint_ticks_[j] = rests ? joint_ticks_[j] + 1 : 0;
    if (rests && joint_ticks_[j] >= view.limits.protocol.stuck_ticks)
      return stuck(view, j, "told to move for stuck_ticks, no change beyond its encoder_step");
  }
  return {};
}

Evidence StuckWatch::after_row(const MotionView& view) {
  const std::size_t part = view.now.action->part;
  if (is_joint_mode(view.mode())) {
    part_ticks_[part] = 0;
    return after_joint_row(view);
  }
  for (const std::size_t j : view.part().joints) joint_ticks_[j] = 0;
  const auto& joints = view.part().joints;
  const bool rests = !joints.empty() && moves_part(view) &&
                     std::none_of(joints.begin(), joints.end(),
                                  [&view](std::size_t j) { return changed(view, j); });
  part_ticks_[part] = rests ? part_ticks_[part] + 1 : 0;
  if (rests && part_ticks_[part] >= view.limits.protocol.stuck_ticks)
    return stuck(view, joints[0],
                 "told to move for stuck_ticks, no joint of the part changed beyond encoder_step");
  return {};
}

void StuckWatch::after_hold(const Limits& limits, std::size_t part) {
  part_ticks_[part] = 0;
  for (const std::size_t j : limits.parts[part].joints) joint_ticks_[j] = 0;
}

void StuckWatch::clear() {
  joint_ticks_.fill(0);
  part_ticks_.fill(0);
}

}  // namespace fairlead
