// What the joints of a part do when its tool is commanded to move: damped least squares.
#pragma once

#include <Eigen/Core>

#include "core/chunk/judgement.hpp"
#include "core/kinematics/forward_kinematics.hpp"

namespace fairlead {

/// A tool's pose, and how it moves with each joint of its own part (`ModelTool::own`), column by
/// column.
struct ToolJacobian {
  Pose tool;
  Eigen::Matrix<double, 6, Eigen::Dynamic, Eigen::ColMajor, 6, max_links> columns;
};

/// Where the frames between the root and the tool have been placed.
ToolJacobian tool_jacobian(const RobotModel& model, const ModelTool& tool, const FramePoses& poses);

/// Moves the part's joints so that its tool makes one motion, as far as they can. Says G030 if the
/// tool would be further from where it is to be than if the joints had stayed, if the search does
/// not end, and if it ends far from `first_step`: then another controller may lead elsewhere.
///
/// `start`: the frames where `joints` are. `end`: of these, those between the root and the tool are
/// placed where the joints get to. `first_step`: where they got to if the way did not bend, by one
/// step of least squares that is hardly damped.
Evidence move_tool(const RobotModel& model, const ModelTool& tool, const Motion6& motion,
                   const FramePoses& start, FramePoses& end, Joints& joints, Joints& first_step);

/// Moves the part's joints until its tool is at `target`, and the tool's frames in `poses` with
/// them. Says G030 if it does not get there, or far from `first_step`, which is as for `move_tool`.
Evidence reach_pose(const RobotModel& model, const ModelTool& tool, const Pose& target,
                    FramePoses& poses, Joints& joints, Joints& first_step);

/// G033: the smallest singular value of the Jacobian, of as many as the part has joints, 6 at most.
double smallest_singular_value(const ToolJacobian& jacobian);

/// Whether that is at least `limit`, by a margin that rounding cannot close: never true in error.
/// The singular value itself, of every row, made whole steps of tools 1.9 times as long.
bool is_clearly_regular(const ToolJacobian& jacobian, double limit);

}  // namespace fairlead
