// G050: the gate's own time, and the limits in its own memory.
#pragma once

#include <cstdint>

#include "core/chunk/judgement.hpp"
#include "core/kinematics/robot_model.hpp"
#include "core/monitor/memory_guard.hpp"
#include "core/release/claim_table.hpp"
#include "fairlead_safety/fixed.hpp"

namespace fairlead {

class SelfMonitor {
 public:
  /// Both must outlive the monitor, and stay where they are.
  SelfMonitor(const Limits& limits, const RobotModel& model);

  /// Arming forgets steps that took too long.
  void begin() { overruns_ = {}; }
  /// A step that took too long: how many have within the window, that one included.
  std::size_t note_overrun(std::uint64_t now_ns);
  /// That many are a stop.
  static constexpr std::size_t overruns_to_stop = 3;

  /// Read the next slice of everything that is guarded. True when a whole pass of something has
  /// ended.
  bool read_on(std::uint64_t now_ns, ClaimTable& claims);
  /// What the newest whole pass found changed, if anything.
  [[nodiscard]] Evidence find_changed(const ClaimTable& claims) const;

 private:
  MemoryGuard limits_;
  MemoryGuard model_;
  TickWindow<4> overruns_;  // when they were, by the gate's clock [ns]
};

/// A step of `step_ns` against its deadline.
Evidence check_step_time(const Limits& limits, std::uint32_t step_ns);

}  // namespace fairlead
