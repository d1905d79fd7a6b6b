// Where a frame is, and how it moves.
#pragma once

#include <Eigen/Geometry>

namespace fairlead {

/// A frame as seen from another: its origin [m] there, and the rotation of its axes.
struct Pose {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
};

/// Velocity of a link's origin [m/s] and of its axes [rad/s].
struct Twist {
  Eigen::Vector3d linear = Eigen::Vector3d::Zero();
  Eigen::Vector3d angular = Eigen::Vector3d::Zero();
};

}  // namespace fairlead
