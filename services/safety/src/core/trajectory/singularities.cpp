// G033: near a singularity joints race, and whose way they go is the controller's choice.

#include <utility>

#include "core/kinematics/inverse_kinematics.hpp"
#include "core/modes/commanded_motion.hpp"
#include "core/trajectory/trajectory_check.hpp"

namespace fairlead {
namespace {

// How many times itself the limit grows by what nobody knows of where a row begins [1/rad].
// Where equal shares left 0.095 and more, and 0.85 rad open, shares between them left 0.028: the
// limit of 0.05 has to be above 0.095 there. Checkpoint vectors, which are to pass, leave 0.76 rad
// open at 0.109.
constexpr double singularity_per_width = 1.25;

// From less than this share of the limit no tool motion may begin: the controller chooses which way
// the joints go. Dampings of 0.001 to 0.05 led apart by whole radians there.
constexpr double least_start = 0.5;

// G033: only what leads towards the singularity is at fault.
Evidence check_singularity(const RobotModel& model, const ActionPart& action,
                           const FramePoses& poses, const FramePoses& before, double width) {
  const PartLimits& part = model.limits.parts[action.part];
  const ModelTool& tool = model.tools[action.part];
  const ToolJacobian jacobian = tool_jacobian(model, tool, poses);
  const double limit = part.singularity_limit * (1.0 + singularity_per_width * width);
  if (is_clearly_regular(jacobian, limit)) return {};
  const double value = smallest_singular_value(jacobian);
  const auto margin_before = [&] {
    return smallest_singular_value(tool_jacobian(model, tool, before)) - limit;
  };
  if (!is_breach(value - limit, margin_before)) return {};
  return of(below(code::singularity, "singular value", value, limit, "1", part.source.view()),
            part.name);
}

}  // namespace

void TrajectoryCheck::note_singular_starts() {
  for (const ActionPart& action : chunk_.parts) {
    if (!moves_tool(action)) continue;
    const ToolJacobian start =
        tool_jacobian(model_, model_.tools[action.part], prediction_.branch(0).poses_now());
    const double least = least_start * model_.limits.parts[action.part].singularity_limit;
    starts_singular_[action.part] = !is_clearly_regular(start, least);
  }
}

// G033 of a row that moves a tool whose chunk begins too near a singularity. Holding is allowed.
Evidence TrajectoryCheck::check_start(const Branch& branch, const ActionPart& action) const {
  if (!starts_singular_[action.part]) return {};
  const PartLimits& part = model_.limits.parts[action.part];
  bool moves = false;
  for (const std::size_t j : part.joints) moves |= branch.now[j] != branch.before[j];
  if (!moves) return {};
  const double value = smallest_singular_value(
      tool_jacobian(model_, model_.tools[action.part], branch.poses_before()));
  return of(below(code::singularity, "singular value", value, least_start * part.singularity_limit,
                  "1", part.source.view()),
            part.name);
}

Evidence TrajectoryCheck::check_singularities(const Branch& branch, const Braking& braking) {
  for (const ActionPart& action : chunk_.parts) {
    const ModelTool& tool = model_.tools[action.part];
    if (!moves_tool(action)) continue;
    const Evidence start = check_start(branch, action);
    if (!start.ok()) return start;
    rest_.place_chain(model_, tool, braking.end());
    for (const FramePoses* poses : {&branch.poses_now(), &std::as_const(rest_)}) {
      const Evidence evidence = check_singularity(model_, action, *poses, branch.poses_before(),
                                                  prediction_.interval_width(action.part));
      if (!evidence.ok()) return evidence;
    }
  }
  return {};
}

}  // namespace fairlead
