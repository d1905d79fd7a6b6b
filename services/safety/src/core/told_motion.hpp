// A row's numbers as motions and poses, and the base's measured motion in the same terms.
#pragma once

#include "fairlead_safety/kinematics.hpp"
#include "row_view.hpp"

namespace fairlead {

/// A delta or a twist: three linear and three angular numbers.
inline Twist halves(const Setpoint& row) {
  return {{row[0], row[1], row[2]}, {row[3], row[4], row[5]}};
}

inline Pose pose_of(const Setpoint& row) {
  return {{row[0], row[1], row[2]}, Eigen::Quaterniond(row[6], row[3], row[4], row[5])};
}

/// The measured twist of base_link's origin along its axes: the base's joints are two slides along
/// odom's x and y and a yaw, about the axis that BaseLimits names (about the origin where it names
/// none). False if the part is built otherwise. (cartesian_modes.cpp)
bool measured_base_twist(const Limits& limits, const PartLimits& part, const MeasuredState& state,
                         Twist& twist);

}  // namespace fairlead
