#include "path_walk.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

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

// The way of a row: all joints go straight from one configuration to the next.
template <class Look>
Evidence check_row_way(const Branch& branch, std::size_t count, double longest, double free_before,
                       double free_now, const Look& look) {
  const auto at = [&](double place, Joints& joints) {
    for (std::size_t j = 0; j < count; ++j)
      joints[j] = branch.before[j] + place * (branch.now[j] - branch.before[j]);
  };
  const auto part = [](const WayPoint& from, const WayPoint& to) { return to.place - from.place; };
  return check_way(WayPoint{0.0, branch.before, free_before}, WayPoint{1.0, branch.now, free_now},
                   Way{longest, at, part, look});
}

// The way of braking, on which some joints stop sooner than others: between two points of it
// nothing goes a larger share of its way than the joint that goes the largest of its own.
template <class Look>
Evidence check_braking_way(const Branch& branch, const Braking& braking, std::size_t count,
                           double longest, double free_now, double free_at_rest, const Look& look) {
  const auto at = [&](double place, Joints& joints) { braking.at(place, joints); };
  const auto part = [&](const WayPoint& from, const WayPoint& to) {
    double largest = 0.0;
    for (std::size_t j = 0; j < count; ++j) {
      const double whole = std::abs(braking.end()[j] - branch.now[j]);
      if (whole == 0.0) continue;
      const double share = std::abs(to.joints[j] - from.joints[j]) / whole;
      largest = std::isnan(largest) || largest > share ? largest : share;
    }
    return largest;
  };
  return check_way(WayPoint{0.0, branch.now, free_now}, WayPoint{1.0, braking.end(), free_at_rest},
                   Way{longest, at, part, look});
}

// G033: only what leads towards the singularity is at fault.
Evidence check_singularity(const PathPlan& plan, const ActionPart& action, const FramePoses& poses,
                           const FramePoses& before) {
  const PartLimits& part = plan.limits.parts[action.part];
  const PlanTool& tool = plan.tools[action.part];
  const ToolJacobian jacobian = tool_jacobian(plan, tool, poses);
  if (is_clearly_regular(jacobian, part.singularity_limit)) return {};
  const double value = smallest_singular_value(jacobian);
  const double was = smallest_singular_value(tool_jacobian(plan, tool, before));
  if (!is_breach(value - part.singularity_limit, was - part.singularity_limit)) return {};
  return of(
      below(code::singularity, "singular value", value, part.singularity_limit, part.source.view()),
      part.name);
}

}  // namespace

PathWalk::PathWalk(const PathPlan& plan, const ClaimLimits& claim, const MeasuredState& state,
                   const ActionChunk& chunk, std::size_t first_row, const RowBefore& before,
                   Companions companions)
    : plan_(plan),
      chunk_(chunk),
      prediction_(plan, claim, state, chunk, first_row, before, companions),
      shape_check_(plan, prediction_.commanded()) {
  rest_ = between_ = prediction_.branch(0).poses_now();
}

Evidence PathWalk::check_next() {
  Evidence evidence;
  if (!has_begun_) evidence = check_momentum();
  has_begun_ = true;
  const Evidence unreachable = prediction_.advance();
  if (!unreachable.ok()) evidence = unreachable;
  for (std::size_t i = 0; i < prediction_.branch_count() && evidence.ok(); ++i)
    evidence = check_branch(i);
  if (!evidence.ok()) evidence.row = static_cast<std::int64_t>(prediction_.row());
  return evidence;
}

// Whatever the first row says, what is measured may go on through its tick, and brake then.
Evidence PathWalk::check_momentum() {
  Evidence evidence;
  for (std::size_t i = 0; i < prediction_.start_count() && evidence.ok(); ++i) {
    Branch branch = prediction_.branch(i);
    if (!prediction_.goes_on(branch)) continue;
    Clearance clearance = clearances_[i];
    const Braking braking(plan_, branch, prediction_.moving(), prediction_.lagging());
    evidence = check_body(branch, braking, clearance);
    if (evidence.ok()) evidence = check_zones(branch, braking);
  }
  return evidence;
}

Evidence PathWalk::check_branch(std::size_t index) {
  const Branch& branch = prediction_.branch(index);
  const Braking braking(plan_, branch, prediction_.moving(), prediction_.lagging());
  Evidence evidence = check_body(branch, braking, clearances_[index]);
  if (evidence.ok()) evidence = check_singularities(branch, braking);
  if (evidence.ok()) evidence = check_zones(branch, braking);
  return evidence;
}

// Bounds, volumes and pairs.
Evidence PathWalk::check_body(const Branch& branch, const Braking& braking, Clearance& clearance) {
  Evidence evidence = check_braking(plan_, branch, braking.end(), prediction_.commanded());
  if (evidence.ok() && !shape_check_.has_nothing())
    evidence = check_shapes(branch, braking, clearance);
  return evidence;
}

// Looks at configurations of a branch on their way.
auto PathWalk::looking_at(const Branch& branch, const Ways& ways, FramePoses& poses) {
  return [this, &branch, &ways, &poses](const Joints& joints, double need, double& free) {
    Clearance found;
    poses.place(plan_, joints);
    const Evidence fault = shape_check_.look(poses, branch.poses_before(), ways, need, found);
    free = shape_check_.free_of(found, ways);
    return fault;
  };
}

// Where the row leads, on the way there, where braking from there ends, on the way to that.
Evidence PathWalk::check_shapes(const Branch& branch, const Braking& braking,
                                Clearance& clearance) {
  const Ways row(plan_, branch.before, branch.now), stop(plan_, branch.now, braking.end());
  const double free_before = shape_check_.free_of(clearance, row);
  Evidence evidence =
      shape_check_.look(branch.poses_now(), branch.poses_before(), Ways(row, stop), 1.0, clearance);
  if (!evidence.ok()) return evidence;
  evidence = check_row_way(branch, plan_.limits.measured_count(), row.longest(), free_before,
                           shape_check_.free_of(clearance, row), looking_at(branch, row, between_));
  return evidence.ok() ? check_shapes_to_rest(branch, braking, clearance, stop) : evidence;
}

Evidence PathWalk::check_shapes_to_rest(const Branch& branch, const Braking& braking,
                                        const Clearance& clearance, const Ways& ways) {
  const double free_now = shape_check_.free_of(clearance, ways);
  if (free_now >= 1.0) return {};
  double free_at_rest = 0.0;
  const Evidence evidence = looking_at(branch, ways, rest_)(braking.end(), 1.0, free_at_rest);
  if (!evidence.ok()) return evidence;
  return check_braking_way(branch, braking, plan_.limits.measured_count(), ways.longest(), free_now,
                           free_at_rest, looking_at(branch, ways, between_));
}

Evidence PathWalk::check_singularities(const Branch& branch, const Braking& braking) {
  for (const ActionPart& action : chunk_.parts) {
    if (!moves_tool(action)) continue;
    rest_.place(plan_, braking.end());
    for (const FramePoses* poses : {&branch.poses_now(), &std::as_const(rest_)}) {
      const Evidence evidence = check_singularity(plan_, action, *poses, branch.poses_before());
      if (!evidence.ok()) return evidence;
    }
  }
  return {};
}

Evidence PathWalk::check_zones(const Branch& branch, const Braking& braking) const {
  if ((prediction_.commanded() & plan_.base_joints) == 0) return {};
  const double row = base_way(plan_, branch.before, branch.now);
  const double stop = base_way(plan_, branch.now, braking.end());
  double margin = 0.0, rest_margin = 0.0;
  Evidence evidence = check_base(plan_, branch.now, branch.before, margin);
  if (evidence.ok()) evidence = check_base(plan_, braking.end(), branch.before, rest_margin);
  if (!evidence.ok()) return evidence;
  const auto looking = [&](double way) {
    return [&, way](const Joints& joints, double, double& free) {
      double found = 0.0;
      const Evidence fault = check_base(plan_, joints, branch.before, found);
      free = free_share(found, way);
      return fault;
    };
  };
  const std::size_t count = plan_.limits.measured_count();
  evidence = check_row_way(branch, count, row, 0.0, free_share(margin, row), looking(row));
  if (!evidence.ok()) return evidence;
  return check_braking_way(branch, braking, count, stop, free_share(margin, stop),
                           free_share(rest_margin, stop), looking(stop));
}

}  // namespace fairlead
