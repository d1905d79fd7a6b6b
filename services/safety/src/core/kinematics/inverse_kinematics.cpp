#include "core/kinematics/inverse_kinematics.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

namespace fairlead {
namespace {

// Least squares weigh what is missed of a turn against what is missed of a shift: by how far the
// turn moves a point that far from the tool [m]. G030 compares by the same weight, or it would
// refuse what is best by it. Jacobians are of a lever of 1 m.
constexpr double lever = 1.0;

// Far from a singularity (smallest singular values of 0.1 and more) the damping takes less than 4 %
// off a motion [m].
constexpr double damping = 0.02;

// A pose counts as reached so near [m, rad], and not at all after so many steps, none longer than
// this [rad or m].
constexpr double pose_tolerance = 1e-6;
constexpr int most_steps = 50;
constexpr double longest_step = 0.5;

// A motion is made by damped steps, until neither the next nor one that is hardly damped would move
// a joint by more than this [rad or m]; then the latter is taken, and the way has ended: what is
// left is of the order of this squared, by the smallest singular value. Where joints have no
// choice, whoever goes on until the tool is there ends there, however he damps; seven end near.
constexpr double last_step = 2e-3;
constexpr int most_motion_steps = 12;

// Of that last step [m]: what joints do not move at all, as of five joints, stays out of it.
constexpr double hardly = 1e-4;

// How much of the longest straight way of a joint of its kind, and how far beside that [rad or m],
// another may be from its own where the motion ends. Beside ways that bend more, controllers that
// damp otherwise ended 30 and 60 mrad from here; beside others up to 20.
constexpr double most_bend = 0.2;
constexpr double least_bend = 2e-3;

// What a motion that the joints cannot make at all may be missed by, above its own size [m].
constexpr double rounding = 1e-9;

using Columns = decltype(ToolJacobian::columns);
using Changes = Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor, max_links>;  // by joint

// `lazyProduct` has no need of memory; other products of these sizes take more time, too.
Eigen::Matrix<double, 6, 6> gram_of_rows(const Columns& columns) {
  return columns.lazyProduct(columns.transpose());
}

// The changes of the joints that come nearest to the motion, those of a singular direction damped.
// `gram`: of the rows.
Changes step_towards(const Columns& columns, Eigen::Matrix<double, 6, 6> gram,
                     const Motion6& motion, double damped_by) {
  gram.diagonal().array() += damped_by * damped_by;
  return columns.transpose().lazyProduct(gram.llt().solve(motion).eval());
}

double largest_of(const Changes& step) { return step.lpNorm<Eigen::Infinity>(); }

void take(const Changes& step, double share, const RobotModel& model, const ModelTool& tool,
          Joints& joints) {
  for (std::size_t i = 0; i < tool.own.size(); ++i)
    joints[model.frames[tool.own[i]].joint] += share * step[static_cast<Eigen::Index>(i)];
}

// Of the rows or of the columns, whichever are fewer; of no columns the rows', which is zero.
using Gram = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, 6, 6>;
Gram smaller_gram(const Columns& columns) {
  if (columns.cols() == 0 || columns.cols() >= 6) return gram_of_rows(columns);
  return columns.transpose().lazyProduct(columns);
}

// The size of a motion [m], a turn by what it moves a point that far from the tool.
double size_of(Motion6 motion) {
  motion.tail<3>() *= lever;
  return motion.norm();
}

// What is still missing of a pose.
Evidence still_missing(std::string_view axis, double value, std::string_view unit) {
  if (value <= pose_tolerance) return {};
  return above(code::unreachable, axis, value, pose_tolerance, unit,
               "a configuration that reaches the pose");
}

// G030: the joints get where the straight way leads, or nearly so.
Evidence check_bend(const RobotModel& model, const ModelTool& tool, const Joints& from,
                    const Joints& straight, const Joints& reached) {
  std::array<double, 2> longest{};  // of turns, of slides
  const auto kind_of = [&](std::size_t j) {
    return model.limits.joints[j].kind == JointKind::prismatic ? 1U : 0U;
  };
  for (const std::size_t frame : tool.own) {
    const std::size_t j = model.frames[frame].joint;
    longest[kind_of(j)] = std::max(longest[kind_of(j)], std::abs(straight[j] - from[j]));
  }
  for (const std::size_t frame : tool.own) {
    const std::size_t j = model.frames[frame].joint;
    const double bend = std::abs(reached[j] - straight[j]);
    const double limit = most_bend * longest[kind_of(j)] + least_bend;
    const JointLimits& joint = model.limits.joints[j];
    if (!(bend <= limit))
      return above(code::unreachable, joint.name.view(), bend, limit, position_unit(joint.kind),
                   "how much its way may bend");
  }
  return {};
}

}  // namespace

ToolJacobian tool_jacobian(const RobotModel& model, const ModelTool& tool,
                           const FramePoses& poses) {
  ToolJacobian jacobian;
  jacobian.tool = pose_at(tool.place, poses);
  jacobian.columns.resize(6, static_cast<Eigen::Index>(tool.own.size()));
  for (std::size_t i = 0; i < tool.own.size(); ++i)
    jacobian.columns.col(static_cast<Eigen::Index>(i)) =
        motion_with(model.frames[tool.own[i]], poses[tool.own[i]], jacobian.tool.position);
  return jacobian;
}

Evidence move_tool(const RobotModel& model, const ModelTool& tool, const Motion6& motion,
                   const FramePoses& start, FramePoses& end, Joints& joints, Joints& first_step) {
  const Pose target = moved(pose_at(tool.place, start), motion);
  const Joints from = joints;
  bool has_ended = false;
  // A long turn bends the way: what one straight step misses, the next makes up for.
  for (int i = 0; i < most_motion_steps && !has_ended; ++i) {
    const ToolJacobian jacobian = tool_jacobian(model, tool, i == 0 ? start : end);
    // The first is exact: rounding would make a motion of none, where a joint may have no room.
    const Motion6 missing = i == 0 ? motion : motion_between(jacobian.tool, target);
    const Eigen::Matrix<double, 6, 6> gram = gram_of_rows(jacobian.columns);
    Changes step = step_towards(jacobian.columns, gram, missing, damping);
    const bool may_end = largest_of(step) <= last_step;
    if (i == 0 || may_end) {
      const Changes whole_step = step_towards(jacobian.columns, gram, missing, hardly);
      if (i == 0) take(whole_step, 1.0, model, tool, first_step = joints);
      has_ended = may_end && largest_of(whole_step) <= last_step;
      if (has_ended) step = whole_step;
    }
    take(step, 1.0, model, tool, joints);
    end.place_chain(model, tool, joints);
  }
  const double missed = size_of(motion_between(pose_at(tool.place, end), target));
  const double whole = size_of(motion);
  if (!(missed <= whole + rounding))
    return above(code::unreachable, "tool motion", missed, whole, "m",
                 "a step of its joints that brings the tool nearer");
  if (has_ended) return check_bend(model, tool, from, first_step, joints);
  return above(code::unreachable, "tool search", most_motion_steps + 1, most_motion_steps, "1",
               "steps in which joints get where the tool is to be");
}

Evidence reach_pose(const RobotModel& model, const ModelTool& tool, const Pose& target,
                    FramePoses& poses, Joints& joints, Joints& first_step) {
  Evidence evidence;
  const Joints from = first_step = joints;
  for (int i = 0; i <= most_steps; ++i) {
    poses.place_chain(model, tool, joints);
    const ToolJacobian jacobian = tool_jacobian(model, tool, poses);
    const Motion6 missing = motion_between(jacobian.tool, target);
    evidence = still_missing("tool position", missing.head<3>().norm(), "m");
    if (evidence.ok()) evidence = still_missing("tool rotation", missing.tail<3>().norm(), "rad");
    if (evidence.ok()) break;
    const Eigen::Matrix<double, 6, 6> gram = gram_of_rows(jacobian.columns);
    if (i == 0)
      take(step_towards(jacobian.columns, gram, missing, hardly), 1.0, model, tool, first_step);
    const Changes step = step_towards(jacobian.columns, gram, missing, damping);
    take(step, std::min(1.0, longest_step / largest_of(step)), model, tool, joints);
  }
  return evidence.ok() ? check_bend(model, tool, from, first_step, joints) : evidence;
}

double smallest_singular_value(const ToolJacobian& jacobian) {
  const Eigen::SelfAdjointEigenSolver<Gram> values(smaller_gram(jacobian.columns),
                                                   Eigen::EigenvaluesOnly);
  return std::sqrt(std::max(values.eigenvalues()[0], 0.0));  // which rounding may make negative
}

bool is_clearly_regular(const ToolJacobian& jacobian, double limit) {
  Gram gram = smaller_gram(jacobian.columns);
  const double least = limit * limit * (1.0 + 1e-6) + 1e-12 * gram.trace();
  gram.diagonal().array() -= least;
  const bool definite = gram.llt().info() == Eigen::Success;
  return std::isfinite(least) && definite;  // NaN would be, too
}

}  // namespace fairlead
