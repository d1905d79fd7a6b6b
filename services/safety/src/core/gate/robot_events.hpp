// What the robot, the runners' heartbeats, the stop key and other gates say.
#pragma once

#include <array>

#include "core/gate/candidates.hpp"
#include "core/gate/state_machine.hpp"
#include "core/monitor/motion_monitor.hpp"
#include "core/release/live_releases.hpp"

namespace fairlead {

class RobotEvents {
 public:
  /// All must outlive it.
  RobotEvents(const Limits& limits, HalLink& hal, ClaimTable& claims, PartHistory& history,
              StopMonitor& stopping, MotionMonitor& motion, StateMachine& machine,
              const ActingRows& rows, const Door& door, LiveReleases& releases,
              Candidates& candidates, Outbox& outbox)
      : limits_(limits),
        hal_(hal),
        claims_(claims),
        history_(history),
        stopping_(stopping),
        motion_(motion),
        machine_(machine),
        rows_(rows),
        door_(door),
        releases_(releases),
        candidates_(candidates),
        outbox_(outbox) {}

  void on_joint_state(const Event& event);
  void on_hal_status(Bytes frame);
  void on_heartbeat(const Event& event);
  void on_stop_level(Bytes frame);
  void on_lease(Bytes frame);

  /// Why the newest hal/status could not be read, "" if it could.
  [[nodiscard]] const Text& status_fault() const { return status_fault_; }

 private:
  void on_new_tick(std::uint64_t received_ns);
  void move_on_disarmed();
  void on_session_news(HalLink::News news);
  void on_rival_state();
  [[nodiscard]] bool is_anothers() const;
  void stop_for_another();
  [[nodiscard]] Text forged_row() const;
  void refuse_first();
  Evidence check_leap(std::uint64_t tick, std::uint64_t received_ns);
  void note_unmoved_joints();
  void repeat_verdicts();
  [[nodiscard]] Text hal_change() const;
  [[nodiscard]] std::uint64_t receipt_of(const Event& event) const;

  const Limits& limits_;
  HalLink& hal_;
  ClaimTable& claims_;
  PartHistory& history_;
  StopMonitor& stopping_;
  MotionMonitor& motion_;
  StateMachine& machine_;
  const ActingRows& rows_;
  const Door& door_;
  LiveReleases& releases_;
  Candidates& candidates_;
  Outbox& outbox_;

  Text status_fault_;
  std::uint64_t counted_rival_ = 0;  // G002: the announced session whose state was counted
  bool said_first_ = false;          // that this session's first state cannot be
  std::array<bool, max_measured> said_outside_{};  // which joints were outside their limits

  // Room for what is too big for the stack of a thread that Zenoh made.
  JointState joint_state_;
  HalStatus hal_status_;
  Lease heard_lease_;
};

/// Why nothing may be armed while both publish.
Text two_hals(const HalLink& hal);

}  // namespace fairlead
