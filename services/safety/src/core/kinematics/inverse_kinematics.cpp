#include "core/kinematics/inverse_kinematics.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
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

// A motion is made by steps, until one moves no joint by more than this [rad or m]; the next would
// move it by a seventh of that at most (where G033 lets through the least). So few steps are enough
// except close to a singularity, and rows that are told one after the other add up to little.
constexpr double last_step = 2e-3;
constexpr int most_motion_steps = 6;

// What a motion that the joints cannot make at all may be missed by, above its own size [m].
constexpr double rounding = 1e-9;

// Its lower half, and of each column what is beside that in a pair of numbers: nobody reads the
// rest.
Square6 gram_of_rows(const ToolJacobian& jacobian) {
  Square6 gram = Square6::Zero();
  for (const Motion6& column : jacobian.all()) {
    gram.leftCols<2>().noalias() += column * column.head<2>().transpose();
    gram.block<4, 2>(2, 2).noalias() += column.tail<4>() * column.segment<2>(2).transpose();
    gram.bottomRightCorner<2, 2>().noalias() += column.tail<2>() * column.tail<2>().transpose();
  }
  return gram;
}

// What one step of least squares changes, joint by joint of the part.
struct Step {
  std::array<double, max_links> changes;  // as many as the part has joints
  double largest = 0.0;
};

// The changes of the joints that come nearest to the motion, those of a singular direction damped.
Step step_towards(const ToolJacobian& jacobian, const Motion6& motion) {
  Square6 gram = gram_of_rows(jacobian);
  gram.diagonal().array() += damping * damping;
  const Motion6 weights = Factors6(gram).solve(motion);
  Step step;
  for (std::size_t i = 0; i < jacobian.count; ++i) {
    step.changes[i] = jacobian.columns[i].dot(weights);
    step.largest = std::max(step.largest, std::abs(step.changes[i]));
  }
  return step;
}

void take(const Step& step, double share, const RobotModel& model, const ModelTool& tool,
          Joints& joints) {
  for (std::size_t i = 0; i < tool.own.size(); ++i)
    joints[model.frames[tool.own[i]].joint] += share * step.changes[i];
}

// Of the rows or of the columns, whichever are fewer: its lower half. What five columns or fewer
// leave of the six by six is as large as all of them together.
Square6 smaller_gram(const ToolJacobian& jacobian) {
  Square6 gram = gram_of_rows(jacobian);
  if (jacobian.count > 5) return gram;
  const double sum = gram.trace();
  gram = sum * Square6::Identity();
  for (std::size_t i = 0; i < jacobian.count; ++i)
    for (std::size_t k = 0; k <= i; ++k)
      gram(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(k)) =
          jacobian.columns[i].dot(jacobian.columns[k]);
  return gram;
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

}  // namespace

ToolJacobian tool_jacobian(const RobotModel& model, const ModelTool& tool,
                           const FramePoses& poses) {
  ToolJacobian jacobian;
  jacobian.tool = pose_at(tool.place, poses);
  for (const std::uint8_t f : tool.own)
    jacobian.columns[jacobian.count++] =
        motion_with(model.frames[f], poses[f], jacobian.tool.position);
  return jacobian;
}

Evidence move_tool(const RobotModel& model, const ModelTool& tool, const Motion6& motion,
                   const FramePoses& start, FramePoses& end, Joints& joints, Joints& first_step) {
  const Pose target = moved(pose_at(tool.place, start), motion);
  // A long turn bends the way: what one straight step misses, the next makes up for.
  for (int i = 0; i < most_motion_steps; ++i) {
    const ToolJacobian jacobian = tool_jacobian(model, tool, i == 0 ? start : end);
    const Step step = step_towards(jacobian, motion_between(jacobian.tool, target));
    take(step, 1.0, model, tool, joints);
    if (i == 0) first_step = joints;
    end.place_chain(model, tool, joints);
    if (step.largest <= last_step) break;
  }
  const double missed = size_of(motion_between(pose_at(tool.place, end), target));
  const double whole = size_of(motion);
  if (missed <= whole + rounding) return {};
  return above(code::unreachable, "tool motion", missed, whole, "m",
               "a step of its joints that brings the tool nearer");
}

Evidence reach_pose(const RobotModel& model, const ModelTool& tool, const Pose& target,
                    FramePoses& poses, Joints& joints, Joints& first_step) {
  Evidence evidence;
  first_step = joints;
  for (int i = 0; i <= most_steps; ++i) {
    poses.place_chain(model, tool, joints);
    const ToolJacobian jacobian = tool_jacobian(model, tool, poses);
    const Motion6 missing = motion_between(jacobian.tool, target);
    evidence = still_missing("tool position", missing.head<3>().norm(), "m");
    if (evidence.ok()) evidence = still_missing("tool rotation", missing.tail<3>().norm(), "rad");
    if (evidence.ok()) break;
    const Step step = step_towards(jacobian, missing);
    if (i == 0) take(step, 1.0, model, tool, first_step);
    take(step, std::min(1.0, longest_step / step.largest), model, tool, joints);
  }
  return evidence;
}

double smallest_singular_value(const ToolJacobian& jacobian) {
  const Eigen::SelfAdjointEigenSolver<Square6> values(smaller_gram(jacobian),
                                                      Eigen::EigenvaluesOnly);
  return std::sqrt(std::max(values.eigenvalues()[0], 0.0));  // which rounding may make negative
}

bool is_clearly_regular(const ToolJacobian& jacobian, double limit) {
  const Square6 gram = smaller_gram(jacobian);
  const double least = limit * limit * (1.0 + 1e-6) + 1e-12 * gram.trace();
  return Factors6(gram - least * Square6::Identity()).definite();
}

}  // namespace fairlead
