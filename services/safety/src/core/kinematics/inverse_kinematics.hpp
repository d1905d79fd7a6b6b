// What the joints of a part do when its tool is told to move: damped least squares.
#pragma once

#include <Eigen/Core>
#include <array>
#include <span>

#include "core/chunk/judgement.hpp"
#include "core/kinematics/forward_kinematics.hpp"

namespace fairlead {

using Square6 = Eigen::Matrix<double, 6, 6>;

/// The factors of L D L^T, L with ones on its diagonal, of which only the lower half of the matrix
/// is read.
class Factors6 {
 public:
  explicit Factors6(const Square6& matrix) : lower_(matrix) {
#pragma GCC unroll 6
    for (int j = 0; j < 6; ++j) {
      const double pivot = lower_(j, j);
      definite_ = definite_ && pivot > 0.0;  // also false for what is no number
      inverse_[j] = 1.0 / pivot;
#pragma GCC unroll 6
      for (int i = j + 1; i < 6; ++i) {
        const double share = lower_(i, j) * inverse_[j];
#pragma GCC unroll 6
        for (int k = j + 1; k <= i; ++k) lower_(i, k) -= share * lower_(k, j);
      }
#pragma GCC unroll 6
      for (int i = j + 1; i < 6; ++i) lower_(i, j) *= inverse_[j];
    }
  }

  /// Whether the matrix is positive definite.
  [[nodiscard]] bool definite() const { return definite_; }

  /// The solution of matrix * x = right.
  [[nodiscard]] Motion6 solve(const Motion6& right) const {
    Motion6 x = right;
#pragma GCC unroll 6
    for (Eigen::Index j = 0; j != x.size(); ++j) {
#pragma GCC unroll 6
      for (Eigen::Index i = j + 1; i < 6; ++i) x[i] -= lower_(i, j) * x[j];
      x[j] *= inverse_[j];
    }
#pragma GCC unroll 6
    for (int j = 5; j != 0; --j)
#pragma GCC unroll 6
      for (int i = 0; i < j; ++i) x[i] -= lower_(j, i) * x[j];
    return x;
  }

 private:
  Square6 lower_;
  Motion6 inverse_;  // of D
  bool definite_ = true;
};

/// A tool's pose, and how it moves with each joint of its own part (`ModelTool::own`).
struct ToolJacobian {
  Pose tool;
  std::size_t count = 0;
  std::array<Motion6, max_links> columns;

  /// The columns that there are.
  [[nodiscard]] std::span<const Motion6> all() const { return std::span(columns).first(count); }
};

/// Where the frames between the root and the tool have been placed.
ToolJacobian tool_jacobian(const RobotModel& model, const ModelTool& tool, const FramePoses& poses);

/// Moves the part's joints so that its tool makes one motion, as far as they can. Says G030 if the
/// tool would be further from where it is to be than if the joints had stayed.
///
/// `start`: the frames where `joints` are. `end`: of these, those between the root and the tool are
/// placed where the joints get to. `first_step`: where they got to if the
/// way did not bend, by one step of least squares.
Evidence move_tool(const RobotModel& model, const ModelTool& tool, const Motion6& motion,
                   const FramePoses& start, FramePoses& end, Joints& joints, Joints& first_step);

/// Moves the part's joints until its tool is at `target`, and the tool's frames in `poses` with
/// them. Says G030 if it does not get there. `first_step` as for `move_tool`.
Evidence reach_pose(const RobotModel& model, const ModelTool& tool, const Pose& target,
                    FramePoses& poses, Joints& joints, Joints& first_step);

/// G033: the smallest singular value of the Jacobian, of as many as the part has joints, 6 at most.
double smallest_singular_value(const ToolJacobian& jacobian);

/// Whether that is at least `limit`, by a margin that rounding cannot close: cheap, and never true
/// in error.
bool is_clearly_regular(const ToolJacobian& jacobian, double limit);

}  // namespace fairlead
