#include "core/monitor/motion_view.hpp"

#include "core/chunk/state_check.hpp"
#include "core/modes/commanded_motion.hpp"

namespace fairlead {
namespace {

Eigen::Vector3d rotation_vector(const Eigen::Quaterniond& rotation) {
  const Eigen::AngleAxisd turn(rotation);
  return turn.angle() * turn.axis();
}

}  // namespace

double change_of(const MotionView& view, std::size_t joint) {
  return measured_change(view.limits.joints[joint], view.before.positions[joint],
                         view.state.positions[joint]);
}

Twist tool_displacement(const MotionView& view) {
  const Kinematics& tree = view.limits.kinematics;
  const std::size_t frame = tree.find(view.now.action->frame_id);
  MeasuredState own = view.before;
  for (const std::size_t j : view.part().joints) own.positions[j] = view.state.positions[j];
  const Pose from = link_pose(tree, view.before, 0, view.part().tool);
  const Pose to = link_pose(tree, own, 0, view.part().tool);
  const Eigen::Quaterniond to_frame = link_pose(tree, view.before, 0, frame).rotation.conjugate();
  return {to_frame * (to.position - from.position),
          to_frame * rotation_vector(to.rotation * from.rotation.conjugate())};
}

bool base_displacement(const MotionView& view, Twist& displacement) {
  MeasuredState in_one_second = view.before;
  for (const std::size_t j : view.part().joints) in_one_second.velocities[j] = change_of(view, j);
  return measured_base_twist(view.limits, view.part(), in_one_second, displacement);
}

PoseError pose_error(const MotionView& view) {
  const Kinematics& tree = view.limits.kinematics;
  const std::size_t frame = tree.find(view.now.action->frame_id);
  const Pose measured = link_pose(tree, view.state, frame, view.part().tool);
  const Pose commanded = pose_of(view.now);
  return {(measured.position - commanded.position).norm(),
          angle_between(measured.rotation, commanded.rotation)};
}

}  // namespace fairlead
