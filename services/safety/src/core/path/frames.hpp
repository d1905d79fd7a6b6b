// Where the moving links are when the joints are somewhere: the gate's kinematics again, laid out
// for speed. Poses are in the root link's frame.
#pragma once

#include <Eigen/Core>
#include <array>

#include "fairlead_safety/path_plan.hpp"

namespace fairlead {

/// Positions of all measured joints [rad or m].
using Joints = std::array<double, max_measured>;

/// Nothing until it has been set.
struct FramePose {
  Eigen::Matrix3d rotation;
  Eigen::Vector3d position;
};
using FramePoses = std::array<FramePose, max_links>;

inline FramePose root_pose() { return {Eigen::Matrix3d::Identity(), Eigen::Vector3d::Zero()}; }

/// One frame from the pose of its parent.
void place_frame(const PlanFrame& frame, const Joints& joints, FramePoses& poses, std::size_t at);

/// The frames that any of `moved` moves; the others stay as they are in `poses`.
void place_frames(const PathPlan& plan, const Joints& joints, JointSet moved, FramePoses& poses);

/// Pose of a link of that name, not a number if there is none.
FramePose frame_pose(const PathPlan& plan, const Name& link, const Joints& joints);

/// A point that is fixed to a frame.
inline Eigen::Vector3d point_in_root(const FramePose& frame, const Eigen::Vector3d& point) {
  return frame.position + frame.rotation * point;
}

/// The largest distance that a point of a capsule or a tool may move, or two of them relative to
/// each other, when the joints go straight from one configuration to another [m].
double motion_bound(const PathPlan& plan, const Joints& from, const Joints& to);

}  // namespace fairlead
