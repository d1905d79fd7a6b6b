#include "core/kinematics/frames.hpp"

#include <algorithm>
#include <cmath>

namespace fairlead {
namespace {

FrameSet bit(std::size_t frame) { return FrameSet{1} << frame; }

void place_on(const FramePose& parent, const PlanFrame& frame, double q, FramePose& pose) {
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

FramePoses& FramePoses::operator=(const FramePoses& other) {
  count_ = other.count_;
  stale_ = other.stale_;
  std::copy_n(other.poses_.begin(), count_, poses_.begin());
  std::copy_n(other.placed_for_.begin(), count_, placed_for_.begin());
  return *this;
}

// A joint that is nowhere compares with nothing: its frames are placed again, nowhere.
void FramePoses::place_one(const PathPlan& plan, const Joints& joints, std::size_t frame) {
  const PlanFrame& planned = plan.frames[frame];
  const double q = joints[planned.joint];
  if ((stale_ & bit(frame)) == 0 && q == placed_for_[frame]) return;
  place_on(poses_[planned.parent], planned, q, poses_[frame]);
  placed_for_[frame] = q;
  stale_ = (stale_ & ~bit(frame)) | planned.children;
}

void FramePoses::begin(const PathPlan& plan) {
  if (count_ != 0) return;
  poses_[0] = {Eigen::Matrix3d::Identity(), Eigen::Vector3d::Zero()};
  count_ = plan.frames.size();
}

void FramePoses::place(const PathPlan& plan, const Joints& joints) {
  begin(plan);
  for (std::size_t f = 1; f < count_; ++f) place_one(plan, joints, f);
}

void FramePoses::place_chain(const PathPlan& plan, const PlanTool& tool, const Joints& joints) {
  begin(plan);
  for (const std::uint8_t f : tool.chain) place_one(plan, joints, f);
}

FramePose pose_at(const PlanPlace& place, const FramePoses& poses) {
  const FramePose& frame = poses[place.frame];
  return {frame.rotation * place.rotation, point_in_root(frame, place.position)};
}

FramePose link_pose(const PathPlan& plan, const Name& link, const FramePoses& poses) {
  const std::size_t index = plan.limits.kinematics.find(link);
  if (index == no_link) return {Eigen::Matrix3d::Constant(unset), Eigen::Vector3d::Constant(unset)};
  return pose_at(plan.places[index], poses);
}

}  // namespace fairlead
