#include "core/trajectory/braking.hpp"

#include <algorithm>
#include <cmath>

#include "core/kinematics/robot_model.hpp"

namespace fairlead {

Braking::Braking(const RobotModel& model, const Branch& branch, JointSet moving, JointSet lagging)
    : model_(model), branch_(branch), moving_(moving), lagging_(lagging) {
  end_ = branch.now;
  for (const std::size_t j : JointsIn(moving)) {
    const double speed = branch.speed[j];
    if (speed == 0.0) continue;
    const double deceleration = model.limits.joints[j].acceleration_limit;
    duration_ = std::max(duration_, waits(j) + std::abs(speed) / deceleration);
    end_[j] += speed * waits(j) + speed * std::abs(speed) / (2.0 * deceleration);
  }
}

// How long it goes on before it brakes.
double Braking::waits(std::size_t joint) const {
  const double reaction =
      (model_.base_joints & only(joint)) != 0 ? model_.limits.base.reaction_s : 0.0;
  return (lagging_ & only(joint)) != 0 ? reaction + model_.limits.joints[joint].stop_lag : reaction;
}

double Braking::position(std::size_t joint, double time) const {
  const double reaction = waits(joint);
  const double speed = branch_.speed[joint];
  const double deceleration = model_.limits.joints[joint].acceleration_limit;
  const double braking = std::clamp(time - reaction, 0.0, std::abs(speed) / deceleration);
  const double lost = std::copysign(0.5 * deceleration * braking * braking, speed);
  return branch_.now[joint] + speed * (std::min(time, reaction) + braking) - lost;
}

void Braking::at(double share, Joints& joints) const {
  joints = branch_.now;
  for (const std::size_t j : JointsIn(moving_))
    if (branch_.speed[j] != 0.0) joints[j] = position(j, share * duration_);
}

double Braking::largest_share(const Joints& from, const Joints& to) const {
  double largest = 0.0;
  for (const std::size_t j : JointsIn(moving_)) {
    const double whole = std::abs(end_[j] - branch_.now[j]);
    if (whole == 0.0) continue;
    const double share = std::abs(to[j] - from[j]) / whole;
    if (std::isnan(share)) return share;
    largest = std::max(largest, share);
  }
  return largest;
}

Evidence check_braking(const RobotModel& model, const Branch& branch, const Joints& end,
                       const Interval& interval, JointSet joints) {
  for (const std::size_t j : JointsIn(joints)) {
    const JointLimits& joint = model.limits.joints[j];
    if (!joint.bounded) continue;
    const double speed = branch.speed[j];
    const double highest = end[j] + (interval.highest[j] - branch.now[j]);
    const double lowest = end[j] + (interval.lowest[j] - branch.now[j]);
    Evidence evidence;
    const double from = branch.before[j];
    if ((speed > 0.0 || from <= joint.bounds.upper) && !(highest <= joint.bounds.upper))
      evidence = above(code::braking, joint.name.view(), highest, joint.bounds.upper,
                       position_unit(joint.kind), joint.source.view());
    if ((speed < 0.0 || from >= joint.bounds.lower) && !(lowest >= joint.bounds.lower))
      evidence = below(code::braking, joint.name.view(), lowest, joint.bounds.lower,
                       position_unit(joint.kind), joint.source.view());
    if (!evidence.ok()) return of(evidence, model.limits.parts[joint.part].name);
  }
  return {};
}

}  // namespace fairlead
