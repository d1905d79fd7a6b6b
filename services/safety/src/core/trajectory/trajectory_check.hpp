// One chunk's rows on their way: what is predicted so far, and whether it may be.
#pragma once

#include <array>

#include "core/chunk/judgement.hpp"
#include "core/trajectory/certify.hpp"

namespace fairlead {

/// Asked row by row, in order, from the first live one on.
class TrajectoryCheck {
 public:
  TrajectoryCheck(const RobotModel& model, const ClaimLimits& claim, const MeasuredState& state,
                  const ActionChunk& chunk, const JudgedRows& rows, const RowBefore& before,
                  Companions companions);

  /// Goes on by one row and judges where that leads. Not past a fault.
  Evidence check_next();
  /// Configurations that were looked at so far.
  [[nodiscard]] std::size_t configurations() const { return budget_.taken(); }

 private:
  Evidence check_momentum();
  Evidence check_momentum_of(const Branch& start);
  Evidence check_branch(std::size_t index);
  Evidence check_row(const Branch& branch, Clearance& clearance);
  Evidence check_between_shares();
  Evidence check_between(std::size_t one, std::size_t other);
  Evidence certify_between(const Branch& one, const StraightMotion& motion,
                           const Clearance* at_start, const Clearance* at_end);
  ShapeConstraint shapes(const Branch& branch, const DisplacementBound& bound, FramePoses& room);
  ZoneConstraint zones(const Branch& branch, double way);
  [[nodiscard]] bool commands_base() const {
    return (prediction_.commanded() & model_.base_joints) != 0;
  }
  Evidence check_body(const Branch& branch, const Braking& braking, const Interval& interval,
                      Clearance& clearance);
  Evidence check_shapes(const Branch& branch, const Braking& braking, Clearance& clearance);
  Evidence certify_stops(const Branch& branch, const Joints& from, const Braking& braking);
  Evidence check_singularities(const Branch& branch, const Braking& braking);  // singularities.cpp
  void note_singular_starts();
  [[nodiscard]] Evidence check_start(const Branch& branch, const ActionPart& action) const;
  void expect_drift();
  void expect_unequal_shares();
  void raise_by_turn(Joints& off) const;
  void raise_by_unequal_shares(Joints& start_off) const;
  void deviate_by(const Joints& off);
  void raise_by_other_stops(const Branch& least, const Branch& most, Joints& off) const;
  [[nodiscard]] Evidence check_other_speeds() const;
  [[nodiscard]] Braking braking_of(const Branch& branch) const;
  Evidence check_zones(const Branch& branch, const Braking& braking);

  const RobotModel& model_;
  const ActionChunk& chunk_;
  std::size_t certified_end_;
  Prediction prediction_;
  ShapeCheck shape_check_;
  bool has_begun_ = false;
  QueryBudget budget_;
  BaseOff base_off_;
  std::array<bool, max_parts> starts_singular_{};
  std::array<Clearance, max_branches> clearances_;  // of each branch where the next row starts
  FramePoses rest_;                                 // where braking ends
  FramePoses between_;
  FramePoses targets_before_;  // of the row that was measured last
};

}  // namespace fairlead
