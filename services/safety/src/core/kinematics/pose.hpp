// Where a frame is, and how it moves.
#pragma once

#include <Eigen/Geometry>

namespace fairlead {

/// Linear [m] and angular [rad] motion along the root link's axes.
using Motion6 = Eigen::Matrix<double, 6, 1>;

/// The rotation of a frame's axes as seen from another, and its origin [m] there. Nothing until it
/// has been set.
struct Pose {
  Eigen::Matrix3d rotation;
  Eigen::Vector3d position;
};

/// Velocity of a link's origin [m/s] and of its axes [rad/s].
struct Twist {
  Eigen::Vector3d linear = Eigen::Vector3d::Zero();
  Eigen::Vector3d angular = Eigen::Vector3d::Zero();
};

/// A point that is fixed to a frame.
inline Eigen::Vector3d point_in_root(const Pose& frame, const Eigen::Vector3d& point) {
  return frame.position + frame.rotation * point;
}

/// A motion along the axes of a frame, which are turned like this in the root.
inline Twist along(const Eigen::Matrix3d& axes, const Motion6& motion) {
  return {axes.transpose() * motion.head<3>(), axes.transpose() * motion.tail<3>()};
}

/// The motion that takes one pose to another, a turn of half a circle at most.
inline Motion6 motion_between(const Pose& from, const Pose& to) {
  const Eigen::AngleAxisd turn(to.rotation * from.rotation.transpose());
  Motion6 motion;
  motion << to.position - from.position, turn.angle() * turn.axis();
  return motion;
}

/// Where a pose is after a motion.
inline Pose moved(const Pose& pose, const Motion6& motion) {
  const Eigen::Vector3d turned = motion.tail<3>();
  const Eigen::AngleAxisd turn(turned.norm(), turned.normalized());
  return {turn.toRotationMatrix() * pose.rotation, pose.position + motion.head<3>()};
}

/// Two motions of a tool in one: it turns by the first, then by the second, and shifts by both.
inline Motion6 one_after_other(const Motion6& first, const Motion6& second) {
  // Without a turn of either exact: rounding would make a motion of none.
  Motion6 both = first + second;
  const double one = first.tail<3>().squaredNorm(), other = second.tail<3>().squaredNorm();
  if (one == 0.0 || other == 0.0) return both;
  const Pose start{Eigen::Matrix3d::Identity(), Eigen::Vector3d::Zero()};
  both.tail<3>() = motion_between(start, moved(moved(start, first), second)).tail<3>();
  return both;
}

}  // namespace fairlead
