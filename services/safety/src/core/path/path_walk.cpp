#include "path_walk.hpp"

#include <algorithm>

#include "base_check.hpp"
#include "breach.hpp"
#include "sweep.hpp"
#include "tool_motion.hpp"

namespace fairlead {
namespace {

bool moves_tool(const ActionPart& action) {
  switch (static_cast<Mode>(action.mode)) {
    case Mode::cartesian_pose:
    case Mode::cartesian_delta:
    case Mode::cartesian_twist:
      return true;
    default:
      return false;
  }
}

auto straight(const Joints& from, const Joints& to, std::size_t count) {
  return [&from, &to, count](double share, Joints& joints) {
    for (std::size_t j = 0; j < count; ++j) joints[j] = from[j] + share * (to[j] - from[j]);
  };
}

// G033: only what leads towards the singularity is at fault.
Evidence check_singularity(const PathPlan& plan, const ActionPart& action, const Joints& joints,
                           const Joints& before) {
  const PartLimits& part = plan.limits.parts[action.part];
  const PlanTool& tool = plan.tools[action.part];
  const ToolJacobian jacobian = tool_jacobian(plan, tool, joints);
  if (is_clearly_regular(jacobian, part.singularity_limit)) return {};
  const double value = smallest_singular_value(jacobian);
  const double was = smallest_singular_value(tool_jacobian(plan, tool, before));
  if (!is_breach(value - part.singularity_limit, was - part.singularity_limit)) return {};
  return at(
      below(code::singularity, "singular value", value, part.singularity_limit, part.source.view()),
      -1, part.name);
}

}  // namespace

PathWalk::PathWalk(const PathPlan& plan, const ClaimLimits& claim, const MeasuredState& state,
                   const ActionChunk& chunk, std::size_t first_row, const RowBefore& before,
                   Companions companions)
    : plan_(plan),
      chunk_(chunk),
      prediction_(plan, claim, state, chunk, first_row, before, companions),
      shape_check_(plan, prediction_.commanded()) {
  if (shape_check_.has_nothing()) return;
  FramePoses& first = between_;
  first[0] = root_pose();
  for (std::size_t f = 1; f < plan.frames.size(); ++f)
    place_frame(plan.frames[f], prediction_.branch(0).now, first, f);
  for (std::size_t i = 0; i < prediction_.branch_count(); ++i) {
    for (FramePoses& poses : shapes_[i].poses)
      for (std::size_t f = 0; f < plan.frames.size(); ++f) poses[f] = first[f];
    if (i > 0)
      place_frames(plan, prediction_.branch(i).now, prediction_.moving(), shapes_[i].poses[0]);
  }
}

Evidence PathWalk::check_next() {
  Evidence evidence = prediction_.advance();
  for (std::size_t i = 0; i < prediction_.branch_count() && evidence.ok(); ++i)
    evidence = check_branch(i);
  if (!evidence.ok()) evidence.row = static_cast<std::int64_t>(prediction_.row());
  return evidence;
}

Evidence PathWalk::check_branch(std::size_t index) {
  const Branch& branch = prediction_.branch(index);
  const Braking braking(plan_, branch, prediction_.moving());
  Evidence evidence = check_braking(plan_, branch, braking.end(), prediction_.commanded());
  if (evidence.ok() && !shape_check_.has_nothing())
    evidence = check_shapes(branch, braking, shapes_[index]);
  if (evidence.ok()) evidence = check_singularities(branch, braking);
  if (evidence.ok() && (prediction_.commanded() & plan_.base_joints) != 0)
    evidence = check_zones(branch, braking);
  return evidence;
}

// Where the row leads, on the way there, where braking from there ends, on the way to that.
Evidence PathWalk::check_shapes(const Branch& branch, const Braking& braking, Shapes& shapes) {
  const JointSet moving = prediction_.moving();
  const FramePoses& before = shapes.poses[shapes.newest];
  shapes.newest ^= 1U;
  FramePoses& now = shapes.poses[shapes.newest];
  const auto bound = [this](const Joints& from, const Joints& to) {
    return motion_bound(plan_, from, to);
  };
  const auto look = [&](const Joints& joints, double need, double& slack) {
    place_frames(plan_, joints, moving, between_);
    return shape_check_.look(between_, before, need, slack);
  };
  WayPoint here{1.0, branch.now, 0.0};
  const double stopping = bound(branch.now, braking.end());
  place_frames(plan_, branch.now, moving, now);
  Evidence evidence = shape_check_.look(
      now, before, std::max(bound(branch.before, branch.now), stopping), here.slack);
  if (!evidence.ok()) return evidence;
  evidence =
      check_way({0.0, branch.before, shapes.slack}, here,
                straight(branch.before, branch.now, plan_.limits.measured_count()), look, bound);
  if (evidence.ok() && !(here.slack >= stopping)) {  // where it is no number, too
    here.share = 0.0;
    WayPoint rest{1.0, braking.end(), 0.0};
    evidence = look(rest.joints, stopping, rest.slack);
    const auto at = [&](double share, Joints& joints) { braking.at(share, joints); };
    if (evidence.ok()) evidence = check_way(here, rest, at, look, bound);
  }
  shapes.slack = here.slack;
  return evidence;
}

Evidence PathWalk::check_singularities(const Branch& branch, const Braking& braking) const {
  for (const ActionPart& action : chunk_.parts) {
    if (!moves_tool(action)) continue;
    for (const Joints* joints : {&branch.now, &braking.end()}) {
      const Evidence evidence = check_singularity(plan_, action, *joints, branch.before);
      if (!evidence.ok()) return evidence;
    }
  }
  return {};
}

Evidence PathWalk::check_zones(const Branch& branch, const Braking& braking) const {
  const auto bound = [this](const Joints& from, const Joints& to) {
    return base_motion_bound(plan_.limits.base, from, to);
  };
  const auto look = [&](const Joints& joints, double, double& slack) {
    return check_base(plan_, joints, branch.before, slack);
  };
  WayPoint start{0.0, branch.before, 0.0}, here{1.0, branch.now, 0.0};
  WayPoint rest{1.0, braking.end(), 0.0};
  Evidence evidence = look(here.joints, 0.0, here.slack);
  if (evidence.ok()) evidence = look(rest.joints, 0.0, rest.slack);
  if (evidence.ok())
    evidence =
        check_way(start, here, straight(branch.before, branch.now, plan_.limits.measured_count()),
                  look, bound);
  here.share = 0.0;
  const auto at = [&](double share, Joints& joints) { braking.at(share, joints); };
  return evidence.ok() ? check_way(here, rest, at, look, bound) : evidence;
}

}  // namespace fairlead
