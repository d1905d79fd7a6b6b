#include "core/monitor/stuck_watch.hpp"

#include <algorithm>
#include <cmath>

#include "core/chunk/state_check.hpp"
#include "core/modes/commanded_motion.hpp"
#include "fairlead_safety/limits.hpp"

namespace fairlead {
namespace {

// A dead band that is no number is none, and a motion that is none is beyond any.
bool exceeds(double motion, double dead_band) { return !(motion <= dead_band); }

}  // namespace

bool DeadBand::exceeded_by(double far, double turned) const {
  return exceeds(far, linear) || exceeds(turned, angular);
}

namespace {

// Which share of a row can be counted on to happen; where none can, what happens on average.
double share_of(const Gain& gain) { return gain.lower > 0.0 ? gain.lower : 0.5 * gain.upper; }

double length_of(const std::array<double, 3>& way) { return std::hypot(way[0], way[1], way[2]); }

// What a part may be commanded of its tool, or of the whole base, while its joints stay in their
// dead bands: of the joints the largest, a turn being as far as it can move the tool.
DeadBand part_dead_band(const MotionView& view) {
  DeadBand most{0.0, 0.0};
  const auto add = [&](std::size_t j, double lever) {
    const JointLimits& joint = view.limits.joints[j];
    const bool slides = joint.kind == JointKind::prismatic;
    if (!slides) most.angular = std::max(most.angular, joint.dead_band);
    most.linear = std::max(most.linear, joint.dead_band * (slides ? 1.0 : lever));
  };
  const PartLimits& part = view.part();
  if (part.tool == no_link) {
    for (const std::size_t j : part.joints) add(j, 0.0);
    return most;
  }
  const auto& links = view.limits.kinematics.links;
  double lever = 0.0;
  for (std::size_t link = part.tool; link != no_link; link = links[link].parent) {
    if (part.joints.contains(links[link].joint)) add(links[link].joint, lever);
    lever += length_of(links[link].translation);
  }
  return most;
}

}  // namespace

void StuckWatch::Commanded::reach(double far, double turned) {
  ++rows;
  if (exceeds(far, linear)) linear = far;
  if (exceeds(turned, angular)) angular = turned;
}

// To and fro within the dead band may move nothing, however often.
void StuckWatch::Commanded::add(const Twist& motion) {
  if (motion.linear.isZero(0.0) && motion.angular.isZero(0.0)) return;
  sum.linear += motion.linear;
  sum.angular += motion.angular;
  reach(sum.linear.norm(), sum.angular.norm());
}

bool StuckWatch::Commanded::beyond(const DeadBand& dead_band, std::uint32_t rows_needed) const {
  return rows >= rows_needed && dead_band.exceeded_by(linear, angular);
}

// Against the last change, not the state before: a slow joint moves by less than a step a tick.
void StuckWatch::note_state(const Limits& limits, const MeasuredState& state) {
  for (std::size_t j = 0; j < limits.joints.size(); ++j) {
    const JointLimits& limit = limits.joints[j];
    Joint& joint = joints_[j];
    const double change = std::abs(measured_change(limit, joint.position, state.positions[j]));
    joint.changed = std::isnan(joint.position) || change > limit.encoder_step;
    if (!joint.changed) continue;
    joint.position = state.positions[j];
    joint.commanded = Commanded{};
    parts_[limit.part] = Commanded{};
  }
}

void StuckWatch::add_joint(const MotionView& view, std::size_t j) {
  const JointLimits& joint = view.limits.joints[j];
  Commanded& commanded = joints_[j].commanded;
  if (view.mode() == static_cast<std::uint8_t>(Mode::joint_velocity)) {
    const double share = share_of(view.modes.joint_velocity.gain) * view.period_s();
    const double velocity = commanded_velocity(view.limits, view.now, j, view.before.positions);
    return commanded.add({{share * velocity, 0.0, 0.0}, Eigen::Vector3d::Zero()});
  }
  const double left = std::abs(measured_change(joint, view.state.positions[j], view.now[j]));
  if (exceeds(left, joint.dead_band)) commanded.reach(left);
}

void StuckWatch::add_part(const MotionView& view) {
  Commanded& commanded = parts_[view.now.action->part];
  if (view.mode() == static_cast<std::uint8_t>(Mode::cartesian_pose)) {
    const PoseError left = pose_error(view);
    if (part_dead_band(view).exceeded_by(left.distance, left.angle))
      commanded.reach(left.distance, left.angle);
    return;
  }
  const CartesianLimits* mode = norm_block(view.modes, view.mode());
  if (mode == nullptr) return;
  const bool per_tick = view.mode() == static_cast<std::uint8_t>(Mode::cartesian_delta);
  const double share = share_of(mode->gain) * (per_tick ? 1.0 : view.period_s());
  const Twist row = halves(view.now);
  commanded.add({share * row.linear, share * row.angular});
}

Evidence StuckWatch::stuck(const MotionView& view, std::size_t joint, std::string_view rule) const {
  const JointLimits& limits = view.limits.joints[joint];
  const double change =
      measured_change(limits, joints_[joint].position, view.state.positions[joint]);
  return declared_as(below(code::stuck, limits.name.view(), std::abs(change), limits.encoder_step,
                           position_unit(limits.kind), rule),
                     "encoder_step");
}

Evidence StuckWatch::after_joint_row(const MotionView& view) {
  for (const std::size_t j : view.part().joints) {
    if (!view.now.commands(j) || joints_[j].changed) continue;
    add_joint(view, j);
    if (joints_[j].commanded.beyond({view.limits.joints[j].dead_band, 0.0},
                                    view.limits.protocol.stuck_ticks))
      return stuck(view, j, "told to move in stuck_ticks rows, no change beyond its encoder_step");
  }
  return {};
}

Evidence StuckWatch::after_row(const MotionView& view) {
  if (is_joint_mode(view.mode())) return after_joint_row(view);
  const auto& joints = view.part().joints;
  if (joints.empty()) return {};
  for (const std::size_t j : joints)
    if (joints_[j].changed) return {};
  add_part(view);
  if (!parts_[view.now.action->part].beyond(part_dead_band(view), view.limits.protocol.stuck_ticks))
    return {};
  return stuck(
      view, joints[0],
      "told to move in stuck_ticks rows, no joint of the part changed beyond encoder_step");
}

// The next position of any joint is a change, with which its part begins anew, too.
void StuckWatch::clear() { joints_.fill(Joint{}); }

}  // namespace fairlead
