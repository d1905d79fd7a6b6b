// Where a link of the robot is, and how it moves, from what its joints are measured to do.
#pragma once

#include <Eigen/Geometry>
#include <cstddef>

#include "core/chunk/judgement.hpp"
#include "core/kinematics/pose.hpp"
#include "fairlead_safety/limits.hpp"

namespace fairlead {

/// T_frame_link: the pose of one link in the frame of another, both anywhere in the tree.
/// NaN where a measurement is, or a link is none of the tree's.
Pose link_pose(const Kinematics& kinematics, const MeasuredState& state, std::size_t frame,
               std::size_t link);

/// The velocity of `link` relative to the root, along the axes of `frame`, Jacobian times joint
/// velocities; only of the joints of `part` where one is given.
Twist link_twist(const Kinematics& kinematics, const MeasuredState& state, std::size_t frame,
                 std::size_t link, const PartLimits* part = nullptr);

/// Angle between two rotations [rad], 0 to pi; q and -q are the same. NaN if a number is.
double angle_between(const Eigen::Quaterniond& a, const Eigen::Quaterniond& b);

}  // namespace fairlead
