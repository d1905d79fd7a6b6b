// Where the joints come to rest when they brake: each by its own declared deceleration.
#pragma once

#include "core/chunk/judgement.hpp"
#include "core/trajectory/prediction.hpp"

namespace fairlead {

/// All joints brake from a branch's configuration and speeds: at once, those of the base after its
/// reaction time at the speed they have, and those of `lagging` after their lag.
class Braking {
 public:
  Braking(const RobotModel& model, const Branch& branch, JointSet moving, JointSet lagging);

  /// Positions when `share` of the time has passed that the last joint needs, 0 to 1.
  void at(double share, Joints& joints) const;
  [[nodiscard]] const Joints& start() const { return branch_.now; }
  [[nodiscard]] const Joints& end() const { return end_; }
  /// Between two points of the way nothing goes a larger share of its own than this: of the joint
  /// that goes the largest.
  [[nodiscard]] double largest_share(const Joints& from, const Joints& to) const;

 private:
  [[nodiscard]] double waits(std::size_t joint) const;
  [[nodiscard]] double position(std::size_t joint, double time) const;

  const RobotModel& model_;
  const Branch& branch_;
  JointSet moving_;
  JointSet lagging_;
  double duration_ = 0.0;
  Joints end_;
};

/// G024: braking ends inside the bounds of every joint of `joints`, from wherever in `interval` it
/// begins. Not of a joint
/// that was beyond already and does not move towards it.
Evidence check_braking(const RobotModel& model, const Branch& branch, const Joints& end,
                       const Interval& interval, JointSet joints);

}  // namespace fairlead
