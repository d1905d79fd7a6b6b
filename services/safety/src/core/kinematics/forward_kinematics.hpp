// Where the links of a robot are, and how they move.
#pragma once

#include <array>
#include <cstddef>

#include "core/chunk/judgement.hpp"
#include "core/kinematics/pose.hpp"
#include "core/kinematics/robot_model.hpp"

namespace fairlead {

/// Positions of all measured joints [rad or m].
using Joints = std::array<double, max_measured>;

/// Where the frames of a model are, in the root's. A frame whose joint and parent are as they were
/// when it was placed is not placed again: most frames of most rows.
class FramePoses {
 public:
  FramePoses() = default;
  FramePoses(const RobotModel& model, const Joints& joints) { place(model, joints); }
  FramePoses(const FramePoses& other) { *this = other; }
  FramePoses& operator=(const FramePoses& other);

  /// All frames, for these joints.
  void place(const RobotModel& model, const Joints& joints);
  /// Only those between the root and a tool. The others stay where they are, also where they hang
  /// on these, until they are placed.
  void place_chain(const RobotModel& model, const ModelTool& tool, const Joints& joints);

  const Pose& operator[](std::size_t frame) const { return poses_[frame]; }
  /// Where the joint of a frame is that has been placed.
  [[nodiscard]] double joint_of(std::size_t frame) const { return placed_for_[frame]; }

 private:
  void begin(const RobotModel& model);
  void place_one(const RobotModel& model, const Joints& joints, std::size_t frame);

  std::size_t count_ = 0;          // of the model's frames, 0 before the first is placed
  FrameSet stale_ = ~FrameSet{0};  // never placed, or before their parent was
  std::array<Pose, max_links> poses_;
  std::array<double, max_links> placed_for_;  // the joint's position
};

/// Pose of a place on a frame.
Pose pose_at(const ModelPlace& place, const FramePoses& poses);

/// T_frame_link: the pose of one link in the frame of another, both anywhere in the tree.
/// NaN where a joint on the way is, or a link is none of the tree's.
Pose link_pose(const RobotModel& model, const FramePoses& poses, std::size_t frame,
               std::size_t link);

/// How a point moves with a frame's joint, by 1 rad or 1 m of that.
inline Motion6 motion_with(const ModelFrame& frame, const Pose& placed,
                           const Eigen::Vector3d& point) {
  const Eigen::Vector3d axis = placed.rotation * frame.axis;
  Motion6 motion;
  if (frame.turns)
    motion << axis.cross(point - placed.position), axis;
  else
    motion << axis, Eigen::Vector3d::Zero();
  return motion;
}

/// The velocity of `link` relative to the root, along the axes of `frame`; only of the joints of
/// `part` where one is given. NaN as a pose is.
Twist link_twist(const RobotModel& model, const MeasuredState& state, std::size_t frame,
                 std::size_t link, const PartLimits* part = nullptr);

}  // namespace fairlead
