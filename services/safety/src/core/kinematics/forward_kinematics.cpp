#include "core/kinematics/forward_kinematics.hpp"

#include <algorithm>
#include <cmath>

namespace fairlead {
namespace {

// T_parent_link at the measured position of its joint.
Pose placement(const Link& link, const MeasuredState& state) {
  const auto& q = link.rotation_xyzw;
  Pose pose{vector(link.translation), Eigen::Quaterniond(q[3], q[0], q[1], q[2])};
  if (link.motion == LinkMotion::turn)
    pose.rotation =
        pose.rotation * Eigen::AngleAxisd(state.positions[link.joint], vector(link.axis));
  else if (link.motion == LinkMotion::slide)
    pose.position += pose.rotation * (state.positions[link.joint] * vector(link.axis));
  return pose;
}

Pose compose(const Pose& T_a_b, const Pose& T_b_c) {
  return {T_a_b.position + T_a_b.rotation * T_b_c.position, T_a_b.rotation * T_b_c.rotation};
}

// The walks go from a link up to the root: a chain needs no memory but where it has got to.
// A link that is not there is nowhere: a pose of NaN, which every comparison refuses.
Pose pose_in_root(const Kinematics& kinematics, const MeasuredState& state, std::size_t link) {
  if (link >= kinematics.links.size())
    return {Eigen::Vector3d::Constant(unset), Eigen::Quaterniond(unset, unset, unset, unset)};
  Pose pose;
  for (; link != 0; link = kinematics.links[link].parent)
    pose = compose(placement(kinematics.links[link], state), pose);
  return pose;
}

}  // namespace

std::size_t Kinematics::find(const Name& name) const {
  for (std::size_t i = 0; i < links.size(); ++i)
    if (links[i].name == name) return i;
  return no_link;
}

Pose link_pose(const Kinematics& kinematics, const MeasuredState& state, std::size_t frame,
               std::size_t link) {
  const Pose T_root_frame = pose_in_root(kinematics, state, frame);
  const Pose T_root_link = pose_in_root(kinematics, state, link);
  const Eigen::Quaterniond to_frame = T_root_frame.rotation.conjugate();
  return {to_frame * (T_root_link.position - T_root_frame.position),
          to_frame * T_root_link.rotation};
}

// Each joint on the way turns or slides all that hangs behind it; `twist` and `behind` (where the
// link's origin is) are told in the frame that the walk has reached.
Twist link_twist(const Kinematics& kinematics, const MeasuredState& state, std::size_t frame,
                 std::size_t link, const PartLimits* part) {
  if (link >= kinematics.links.size())
    return {Eigen::Vector3d::Constant(unset), Eigen::Vector3d::Constant(unset)};
  Twist twist;
  Pose behind;
  for (; link != 0; link = kinematics.links[link].parent) {
    const Link& here = kinematics.links[link];
    const bool counts = part == nullptr || part->joints.contains(here.joint);
    if (here.motion != LinkMotion::fixed && counts) {
      const Eigen::Vector3d rate = state.velocities[here.joint] * vector(here.axis);
      if (here.motion == LinkMotion::turn) {
        twist.angular += rate;
        twist.linear += rate.cross(behind.position);
      } else {
        twist.linear += rate;
      }
    }
    const Pose step = placement(here, state);
    behind = compose(step, behind);
    twist = {step.rotation * twist.linear, step.rotation * twist.angular};
  }
  const Eigen::Quaterniond to_frame = pose_in_root(kinematics, state, frame).rotation.conjugate();
  return {to_frame * twist.linear, to_frame * twist.angular};
}

double angle_between(const Eigen::Quaterniond& a, const Eigen::Quaterniond& b) {
  return a.angularDistance(b);
}

namespace {

FrameSet bit(std::size_t frame) { return FrameSet{1} << frame; }

void place_on(const FramePose& parent, const ModelFrame& frame, double q, FramePose& pose) {
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

FramePose pose_at(const ModelPlace& place, const FramePoses& poses) {
  const FramePose& frame = poses[place.frame];
  return {frame.rotation * place.rotation, point_in_root(frame, place.position)};
}

FramePose link_pose(const RobotModel& model, const Name& link, const FramePoses& poses) {
  const std::size_t index = model.limits.kinematics.find(link);
  if (index == no_link) return {Eigen::Matrix3d::Constant(unset), Eigen::Vector3d::Constant(unset)};
  return pose_at(model.places[index], poses);
}

}  // namespace fairlead
