// Whether a robot may stop wherever each of its joints likes, between two configurations.
#pragma once

#include "core/geometry/shape_check.hpp"

namespace fairlead {

/// G031 and G032 in all of a cell. Where the shapes are not clear of each other by what they can
/// move in it, its corner is queried that is the worst to first order. It is halved as long as one
/// of them may be beyond a limit by more than `tolerated` anywhere in it.
class StopCells {
 public:
  /// `before`: where the row begins. `middle`, `corner`: room to place the shapes in.
  StopCells(const RobotModel& model, ShapeCheck& check, const FramePoses& before,
            QueryBudget& budget, FramePoses& middle, FramePoses& corner)
      : model_(model),
        check_(check),
        before_(before),
        budget_(budget),
        middle_poses_(middle),
        corner_poses_(corner) {}

  /// Each joint is between these two, whatever the others do.
  Evidence certify(const Joints& from, const Joints& to);

 private:
  Evidence certify_cell();
  Evidence query(const Joints& joints, FramePoses& poses, const DisplacementBound& bound,
                 double share, Clearance& found);
  // Not inlined: that would take its 20 kB of stack once for each time a cell has been halved.
  [[gnu::noinline]] Evidence check_cell(std::size_t& widest);
  [[nodiscard]] std::size_t widest_of(JointSet movers) const;

  static constexpr double tolerated = 0.0005;  // [m]
  static constexpr std::size_t none = max_measured;

  const RobotModel& model_;
  ShapeCheck& check_;
  const FramePoses& before_;
  QueryBudget& budget_;
  FramePoses& middle_poses_;
  FramePoses& corner_poses_;
  Joints middle_;
  Joints half_;
};

}  // namespace fairlead
