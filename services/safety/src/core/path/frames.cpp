#include "frames.hpp"

#include <cmath>

namespace fairlead {

void place_frame(const PlanFrame& frame, const Joints& joints, FramePoses& poses, std::size_t at) {
  const FramePose& parent = poses[frame.parent];
  const double q = joints[frame.joint];
  FramePose& pose = poses[at];
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

void place_frames(const PathPlan& plan, const Joints& joints, JointSet moved, FramePoses& poses) {
  for (std::size_t f = 1; f < plan.frames.size(); ++f)
    if ((plan.frames[f].movers & moved) != 0) place_frame(plan.frames[f], joints, poses, f);
}

// Up to the root: a chain needs no memory but where it has got to.
FramePose frame_pose(const PathPlan& plan, const Name& link, const Joints& joints) {
  const std::size_t index = plan.limits.kinematics.find(link);
  if (index == no_link) return {Eigen::Matrix3d::Constant(unset), Eigen::Vector3d::Constant(unset)};
  const PlanPlace& place = plan.places[index];
  FramePose pose{place.rotation, place.position};
  for (std::size_t f = place.frame; f != 0; f = plan.frames[f].parent) {
    const PlanFrame& frame = plan.frames[f];
    const double q = joints[frame.joint];
    Eigen::Matrix3d turned = frame.still;
    if (frame.turns) turned += std::cos(q) * frame.cosine + std::sin(q) * frame.sine;
    const Eigen::Vector3d origin = frame.turns ? frame.origin : frame.origin + q * frame.slide;
    pose = {turned * pose.rotation, origin + turned * pose.position};
  }
  return pose;
}

double motion_bound(const PathPlan& plan, const Joints& from, const Joints& to) {
  double bound = 0.0;
  for (std::size_t j = 0; j < plan.limits.measured_count(); ++j)
    if (plan.reach[j] != 0.0) bound += plan.reach[j] * std::abs(to[j] - from[j]);
  return bound;
}

}  // namespace fairlead
