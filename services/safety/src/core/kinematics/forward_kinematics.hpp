// Where the links of the robot are, and how they move: from what its joints are measured to do; and
// of the frames of a model, for any joints, laid out for speed. Those poses are in the root link's
// frame.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cstddef>

#include "core/chunk/judgement.hpp"
#include "core/kinematics/pose.hpp"
#include "core/kinematics/robot_model.hpp"
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

/// Positions of all measured joints [rad or m].
using Joints = std::array<double, max_measured>;

/// Nothing until it has been set.
struct FramePose {
  Eigen::Matrix3d rotation;
  Eigen::Vector3d position;
};

/// Where the frames of a model are. A frame whose joint and parent are as they were when it was
/// placed is not placed again: most frames of most rows.
class FramePoses {
 public:
  FramePoses() = default;
  FramePoses(const FramePoses& other) { *this = other; }
  FramePoses& operator=(const FramePoses& other);

  /// All frames, for these joints.
  void place(const RobotModel& model, const Joints& joints);
  /// Only those between the root and a tool. The others stay where they are, also where they hang
  /// on these, until they are placed.
  void place_chain(const RobotModel& model, const ModelTool& tool, const Joints& joints);

  const FramePose& operator[](std::size_t frame) const { return poses_[frame]; }
  /// Where the joint of a frame is that has been placed.
  [[nodiscard]] double joint_of(std::size_t frame) const { return placed_for_[frame]; }

 private:
  void begin(const RobotModel& model);
  void place_one(const RobotModel& model, const Joints& joints, std::size_t frame);

  std::size_t count_ = 0;          // of the model's frames, 0 before the first is placed
  FrameSet stale_ = ~FrameSet{0};  // never placed, or before their parent was
  std::array<FramePose, max_links> poses_;
  std::array<double, max_links> placed_for_;  // the joint's position
};

/// Pose of a place on a frame.
FramePose pose_at(const ModelPlace& place, const FramePoses& poses);

/// Pose of a link of that name, not a number if there is none.
FramePose link_pose(const RobotModel& model, const Name& link, const FramePoses& poses);

/// A point that is fixed to a frame.
inline Eigen::Vector3d point_in_root(const FramePose& frame, const Eigen::Vector3d& point) {
  return frame.position + frame.rotation * point;
}

}  // namespace fairlead
