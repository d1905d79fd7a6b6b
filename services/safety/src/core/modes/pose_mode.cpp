// cartesian_pose: where the part's tool frame is to be, in a frame that the part does not move.

#include "core/modes/commanded_motion.hpp"
#include "core/modes/mode_table.hpp"

namespace fairlead {
namespace {

// A quaternion that has come through float32 is this close to a unit one.
constexpr double norm_tolerance = 1e-6;

Evidence step_from(std::uint32_t code, const RowView& view, const Pose& before) {
  const PoseLimits& mode = view.modes.cartesian_pose;
  const Pose now = pose_of(view.now);
  const Evidence linear = at_most(code, "linear", (now.position - before.position).norm(),
                                  mode.linear_step_limit, mode.source);
  if (!linear.ok()) return linear;
  return at_most(code, "angular", angle_between(now.rotation, before.rotation),
                 mode.angular_step_limit, mode.source);
}

}  // namespace

Evidence pose_absolute(const RowView& view) {
  constexpr std::array<std::string_view, 3> axes{"x", "y", "z"};
  const PoseLimits& mode = view.modes.cartesian_pose;
  for (std::size_t i = 0; i < axes.size(); ++i) {
    const Evidence evidence =
        in_range(axes[i], view.now[i], mode.lower[i], mode.upper[i], mode.source);
    if (!evidence.ok()) return evidence;
  }
  const double norm = pose_of(view.now).rotation.norm();
  return in_range("quaternion norm", norm, 1.0 - norm_tolerance, 1.0 + norm_tolerance, mode.source);
}

// Like a joint target, a pose starts where the tool is measured to be, also while rows act.
Evidence pose_start(const RowView& view, const Setpoint*) {
  const Kinematics& tree = view.limits.kinematics;
  const std::size_t frame = tree.find(view.now.action->frame_id);
  return step_from(code::start, view, link_pose(tree, view.state, frame, view.part().tool));
}

Evidence pose_step(std::uint32_t code, const RowView& view, const Setpoint& before) {
  return step_from(code, view, pose_of(before));
}

}  // namespace fairlead
