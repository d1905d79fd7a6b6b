// Each new state against the rows that acted before it: G013, G040, G041, G042.
#pragma once

#include "core/chunk/judgement.hpp"
#include "core/monitor/grasp_watch.hpp"
#include "core/monitor/stuck_watch.hpp"
#include "core/release/claim_table.hpp"

namespace fairlead {

class MotionMonitor {
 public:
  /// `model` must outlive the monitor.
  explicit MotionMonitor(const RobotModel& model) : model_(model), limits_(model.limits) {}

  /// Arming forgets all states and rows before.
  void begin();
  /// What the newest state says of the rows that acted before it. Asked before the plans move on.
  Evidence check(const MeasuredState& before, const MeasuredState& now, const ClaimTable& claims);

 private:
  Evidence check_part(std::size_t part, const MeasuredState& before, const MeasuredState& now,
                      const ClaimTable& claims);

  const RobotModel& model_;
  const Limits& limits_;
  bool knows_before_ = false;  // the newest state may be compared with the next
  StuckWatch stuck_;
  GraspWatch grasp_;
};

}  // namespace fairlead
