#include "core/monitor/motion_view.hpp"

#include "core/chunk/state_check.hpp"
#include "core/modes/commanded_motion.hpp"

namespace fairlead {

double change_of(const MotionView& view, std::size_t joint) {
  return measured_change(view.limits.joints[joint], view.before.positions[joint],
                         view.state.positions[joint]);
}

Twist tool_displacement(const MotionView& view) {
  Joints own = view.before.positions;
  for (const std::size_t j : view.part().joints) own[j] = view.state.positions[j];
  const FramePoses before(view.model, view.before.positions), after(view.model, own);
  const ModelPlace& tool = view.model.places[view.part().tool];
  const ModelPlace& frame = view.model.places[link_of(view.limits, view.now)];
  return along(pose_at(frame, before).rotation,
               motion_between(pose_at(tool, before), pose_at(tool, after)));
}

bool base_displacement(const MotionView& view, Twist& displacement) {
  MeasuredState in_one_second = view.before;
  for (const std::size_t j : view.part().joints) in_one_second.velocities[j] = change_of(view, j);
  return measured_base_twist(view.limits, view.part(), in_one_second, displacement);
}

PoseError pose_error(const MotionView& view) {
  const Pose measured = link_pose(view.model, {view.model, view.state.positions},
                                  link_of(view.limits, view.now), view.part().tool);
  const Motion6 off = motion_between(measured, pose_of(view.now));
  return {off.head<3>().norm(), off.tail<3>().norm()};
}

}  // namespace fairlead
