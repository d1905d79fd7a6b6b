// G040: did the part move as the rows that acted commanded?
#pragma once

#include "core/monitor/motion_view.hpp"

namespace fairlead {

/// Targets against where the robot is; velocities, deltas and twists against the share of them that
/// the tracking model says happens, where the two states are consecutive. A gripper's opening and
/// a composite switch are not judged.
Evidence check_tracking(const MotionView& view);

/// The motions that a tracking model allows in a tick: everything between where motion came from
/// (two points) and the share, from `gain.lower` to `gain.upper`, of what a row asks for. A joint's
/// velocity is a point on the first axis.
struct TrackingSpan {
  Eigen::Vector3d from = Eigen::Vector3d::Zero();
  Eigen::Vector3d from_too = Eigen::Vector3d::Zero();
  Eigen::Vector3d slow = Eigen::Vector3d::Zero();  // the lower share of what was asked for
  Eigen::Vector3d fast = Eigen::Vector3d::Zero();  // the upper share

  /// After a row that asked for `before`.
  static TrackingSpan after_row(const Gain& gain, const Eigen::Vector3d& before,
                                const Eigen::Vector3d& commanded) {
    return {gain.lower * before, gain.upper * before, gain.lower * commanded,
            gain.upper * commanded};
  }
  /// After a hold: from standstill, or from what was measured when the row began.
  static TrackingSpan after_hold(const Gain& gain, const Eigen::Vector3d& measured,
                                 const Eigen::Vector3d& commanded) {
    return {Eigen::Vector3d::Zero(), measured, gain.lower * commanded, gain.upper * commanded};
  }

  /// Distance of a measured motion to the nearest one allowed, 0 inside; NaN if a number is.
  [[nodiscard]] double distance(const Eigen::Vector3d& motion) const;
};

}  // namespace fairlead
