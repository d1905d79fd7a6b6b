// What a whole cell of configurations leaves to a shape's limit. Two shapes are no nearer to each
// other than each is to a plane between them, wherever they go: here the one that is square to
// their gap in the middle of the cell.
#include <cmath>
#include <initializer_list>

#include "core/geometry/shape_check.hpp"

namespace fairlead {

// A point on a frame, as seen from the frame `base` on which that hangs. The less it reaches along
// `direction`, the nearer is the limit.
struct Facing {
  std::size_t frame;
  std::size_t base;
  double extent;  // no point of the shape is further from the frame's origin
  Eigen::Vector3d point;
  Eigen::Vector3d direction;
};

// The worst corner of those that are added.
class WorstCorner {
 public:
  WorstCorner(const RobotModel& model, const Cell& cell) : model_(model), cell_(cell) {}

  // Of what has `offset` and what the points reach along their directions left, or more.
  void add(double offset, std::initializer_list<Facing> points) {
    CellCorner corner;
    corner.margin = offset;
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

namespace {

// The furthest that a box reaches along a direction.
double reach_along(const Box& box, const Eigen::Vector3d& direction) {
  return box.lower.cwiseProduct(direction).cwiseMax(box.upper.cwiseProduct(direction)).sum();
}

}  // namespace

CellCorner ShapeCheck::worst_corner(std::size_t shape, const FramePoses& before,
                                    const Cell& cell) const {
  WorstCorner worst(model_, cell);
  if (shape < pairs_.size()) {
    add_pair(model_.pairs[pairs_[shape]], before, cell, worst);
    return worst.found();
  }
  const std::size_t tool = shape - pairs_.size();
  for (const Volume& volume : model_.limits.workspace.volumes) {
    if (tool < tools_.size())
      add_tool(model_.tools[tools_[tool]], volume, before, cell, worst);
    else if (volume.keep_out)
      add_capsule(capsules_[tool - tools_.size()], volume, before, cell, worst);
  }
  return worst.found();
}

void ShapeCheck::add_pair(const ModelPair& pair, const FramePoses& before, const Cell& cell,
                          WorstCorner& worst) const {
  const double clearance = model_.limits.collision.clearance;
  const double margin_before =
      pair_distance(pair, before) - clearance - off(deviation_before_, pair);
  const Excuse excuse = excuse_of(pair.movers, clearance_drift_, Excuse::none);
  const ModelCapsule &first = model_.capsules[pair.first], &second = model_.capsules[pair.second];
  const Segment one = segment(pair.first, cell.poses), other = segment(pair.second, cell.poses);
  const Eigen::Vector3d apart = segment_gap(one, other).normalized();
  const double needed = first.radius + second.radius + clearance + clearance_drift_ +
                        off(deviation_, pair) - excused(margin_before, excuse);
  for (const Eigen::Vector3d& end : {one.a, one.b})
    for (const Eigen::Vector3d& other_end : {other.a, other.b})
      worst.add(-needed, {{first.frame, pair.common, first.extent, end, apart},
                          {second.frame, pair.common, second.extent, other_end, -apart}});
}

void ShapeCheck::add_tool(const ModelTool& tool, const Volume& volume, const FramePoses& before,
                          const Cell& cell, WorstCorner& worst) const {
  const Eigen::Vector3d point = tool_at(tool, cell.poses), was = tool_at(tool, before);
  const double extent = tool.place.position.norm(), off_before = off(deviation_before_, tool);
  const double needed = tool_drift_ + off(deviation_, tool);
  const Excuse excuse = excuse_of(tool.movers, tool_drift_, Excuse::better);
  const Box box = box_of(volume);
  const auto face = [&](double limit, const Eigen::Vector3d& direction, double margin_before) {
    worst.add(excused(margin_before - off_before, excuse) - limit - needed,
              {{tool.place.frame, 0, extent, point, direction}});
  };
  if (volume.keep_out) {
    const Eigen::Vector3d apart = box_direction({point, point}, box);
    return face(reach_along(box, apart), apart, box_distance({was, was}, box));
  }
  for (Eigen::Index i = 0; i < 3; ++i) {
    const Eigen::Vector3d up = Eigen::Vector3d::Unit(i);
    face(box.lower[i], up, was[i] - box.lower[i]);
    face(-box.upper[i], -up, box.upper[i] - was[i]);
  }
}

void ShapeCheck::add_capsule(std::size_t capsule, const Volume& volume, const FramePoses& before,
                             const Cell& cell, WorstCorner& worst) const {
  const ModelCapsule& shape = model_.capsules[capsule];
  const Box box = box_of(volume);
  const double margin_before =
      box_distance(segment(capsule, before), box) - shape.radius - off(deviation_before_, shape);
  const JointSet movers = model_.frames[shape.frame].movers;
  const Excuse excuse = excuse_of(movers, tool_drift_, Excuse::better);
  const Segment placed = segment(capsule, cell.poses);
  const Eigen::Vector3d apart = box_direction(placed, box);
  const double needed = reach_along(box, apart) + shape.radius + tool_drift_ +
                        off(deviation_, shape) - excused(margin_before, excuse);
  for (const Eigen::Vector3d& end : {placed.a, placed.b})
    worst.add(-needed, {{shape.frame, 0, shape.extent, end, apart}});
}

}  // namespace fairlead
