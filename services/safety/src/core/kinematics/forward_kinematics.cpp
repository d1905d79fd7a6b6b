#include "core/kinematics/forward_kinematics.hpp"

#include <algorithm>
#include <cmath>

namespace fairlead {
namespace {

FrameSet bit(std::size_t frame) { return FrameSet{1} << frame; }

void place_on(const Pose& parent, const ModelFrame& frame, double q, Pose& pose) {
  if (!frame.turns) {
    pose.rotation.noalias() = parent.rotation * frame.still;
    pose.position = point_in_root(parent, frame.origin + q * frame.slide);
    return;
  }
  const double sine = std::sin(q), cosine = std::cos(q);
  pose.rotation.noalias() =
      parent.rotation * (frame.still + cosine * frame.cosine + sine * frame.sine).eval();
  pose.position = point_in_root(parent, frame.origin);
}

}  // namespace

std::size_t Kinematics::find(const Name& name) const {
  for (std::size_t i = 0; i < links.size(); ++i)
    if (links[i].name == name) return i;
  return no_link;
}

FramePoses& FramePoses::operator=(const FramePoses& other) {
  count_ = other.count_;
  stale_ = other.stale_;
  std::copy_n(other.poses_.begin(), count_, poses_.begin());
  std::copy_n(other.placed_for_.begin(), count_, placed_for_.begin());
  return *this;
}

// A joint that is nowhere compares with nothing: its frames are placed again, nowhere.
void FramePoses::place_one(const RobotModel& model, const Joints& joints, std::size_t frame) {
  const ModelFrame& planned = model.frames[frame];
  const double q = joints[planned.joint];
  if ((stale_ & bit(frame)) == 0 && q == placed_for_[frame]) return;
  place_on(poses_[planned.parent], planned, q, poses_[frame]);
  placed_for_[frame] = q;
  stale_ = (stale_ & ~bit(frame)) | planned.children;
}

void FramePoses::begin(const RobotModel& model) {
  if (count_ != 0) return;
  poses_[0] = {Eigen::Matrix3d::Identity(), Eigen::Vector3d::Zero()};
  count_ = model.frames.size();
}

void FramePoses::place(const RobotModel& model, const Joints& joints) {
  begin(model);
  for (std::size_t f = 1; f < count_; ++f) place_one(model, joints, f);
}

void FramePoses::place_chain(const RobotModel& model, const ModelTool& tool, const Joints& joints) {
  begin(model);
  for (const std::uint8_t f : tool.chain) place_one(model, joints, f);
}

Pose pose_at(const ModelPlace& place, const FramePoses& poses) {
  const Pose& frame = poses[place.frame];
  return {frame.rotation * place.rotation, point_in_root(frame, place.position)};
}

Pose link_pose(const RobotModel& model, const FramePoses& poses, std::size_t frame,
               std::size_t link) {
  const Pose T_root_frame = pose_at(model.places[frame], poses);
  const Pose T_root_link = pose_at(model.places[link], poses);
  const Eigen::Matrix3d to_frame = T_root_frame.rotation.transpose();
  return {to_frame * T_root_link.rotation,
          to_frame * (T_root_link.position - T_root_frame.position)};
}

// Where the link is nowhere, it moves by no number, also where no joint of the part moves it.
Twist link_twist(const RobotModel& model, const MeasuredState& state, std::size_t frame,
                 std::size_t link, const PartLimits* part) {
  const FramePoses poses(model, state.positions);
  const Eigen::Vector3d point = pose_at(model.places[link], poses).position;
  Motion6 motion;
  motion << 0.0 * point, 0.0 * point;
  for (std::size_t f = model.places[link].frame; f != 0; f = model.frames[f].parent) {
    const ModelFrame& here = model.frames[f];
    if (part == nullptr || part->joints.contains(here.joint))
      motion += state.velocities[here.joint] * motion_with(here, poses[f], point);
  }
  return along(pose_at(model.places[frame], poses).rotation, motion);
}

}  // namespace fairlead
