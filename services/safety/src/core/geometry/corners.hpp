// Where in a cell of configurations something comes nearest to its limit.
#pragma once

#include <cmath>
#include <initializer_list>
#include <limits>

#include "core/trajectory/displacement_bound.hpp"

namespace fairlead {

/// All configurations in which no joint is further than `half` from `middle`. `poses`: in the
/// middle. `bound`: of what moves from there to anywhere in it.
struct Cell {
  const Joints& middle;
  const Joints& half;
  const FramePoses& poses;
  const DisplacementBound& bound;
};

/// A corner of a cell, by what each joint goes from the middle; and what is left to a limit there,
/// by the velocities in the middle. Nothing in the cell has less by more than `bend`.
struct CellCorner {
  double margin = std::numeric_limits<double>::infinity();
  double bend = 0.0;
  Joints ways;

  [[nodiscard]] double least() const { return margin - bend; }
};

/// A point on a frame, as seen from the frame `base` on which that hangs. The less it reaches along
/// `direction`, the nearer is the limit.
struct Facing {
  std::size_t frame;
  std::size_t base;
  double extent;  // no point of the shape is further from the frame's origin
  Eigen::Vector3d point;
  Eigen::Vector3d direction;
};

/// The worst corner of those that are added.
class WorstCorner {
 public:
  WorstCorner(const RobotModel& model, const Cell& cell) : model_(model), cell_(cell) {}

  /// Of what has `offset` and what the points reach along their directions left, or more.
  void add(double offset, std::initializer_list<Facing> points) {
    CellCorner corner;
    corner.margin = offset;
    corner.ways.fill(0.0);
    for (const Facing& facing : points) go_nearer(facing, corner);
    if (!(corner.least() >= found_.least())) found_ = corner;
  }
  [[nodiscard]] const CellCorner& found() const { return found_; }

 private:
  void go_nearer(const Facing& facing, CellCorner& corner) const {
    corner.margin += facing.direction.dot(facing.point);
    corner.bend += cell_.bound.bend(facing.frame, facing.extent, facing.base);
    for (std::size_t f = facing.frame; f != facing.base; f = model_.frames[f].parent) {
      const ModelFrame& frame = model_.frames[f];
      const double half = cell_.half[frame.joint];
      if (half == 0.0) continue;
      const Motion6 motion = motion_with(frame, cell_.poses[f], facing.point);
      const double slope = facing.direction.dot(motion.head<3>());
      corner.margin -= std::abs(slope) * half;
      corner.ways[frame.joint] = -std::copysign(half, slope);
    }
  }

  const RobotModel& model_;
  const Cell& cell_;
  CellCorner found_;
};

}  // namespace fairlead
