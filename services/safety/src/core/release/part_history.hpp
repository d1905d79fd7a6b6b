// What each part did: the rows that acted, in which mode it still moves (G025), and where its tool
// was to go (G026).
#pragma once

#include <cstdint>

#include "core/modes/row_view.hpp"
#include "core/release/claim_table.hpp"
#include "core/release/part_memory.hpp"

namespace fairlead {

class PartHistory {
 public:
  /// `model` must outlive the history.
  explicit PartHistory(const RobotModel& model) : model_(model), limits_(model.limits) {}

  /// Arming in `state`: nothing is known of what happened before.
  void begin(const MeasuredState& state);
  /// A new session executes nothing that was released to another.
  void begin_session();
  /// A state of a later tick comes: the newest so far was of this one, 0 if there was none.
  void end_tick(std::uint64_t tick) { seen_tick_ = tick; }
  /// By what each part did in the tick before `now`, which began at `before`.
  void update(const MeasuredState& before, const MeasuredState& now, const ClaimTable& claims);
  /// Also while disarmed: what a part could have done before it held says nothing of later ticks.
  void forget_held(const MeasuredState& now);

  /// The newest release of a claim has gone out.
  void note_released(const LiveClaim& claim);
  /// A claim ends. The HAL may still execute a row of it.
  void keep(const LiveClaim& claim);

  /// A state tells what acted in the tick before it. Of the ticks before that, which had a state
  /// each that was lost, it is only known what had been released. `tick`: of the newest state.
  [[nodiscard]] bool may_have_acted(std::size_t part, std::uint64_t tick) const {
    return tick - seen_tick_ > 1 && memories_[part].released.end_tick > seen_tick_;
  }
  [[nodiscard]] const PartMemories& memories() const { return memories_; }

 private:
  [[nodiscard]] Setpoint acted_row(std::size_t part, const MeasuredState& now,
                                   const ClaimTable& claims) const;
  [[nodiscard]] Switch switched(const MeasuredState& now, const ClaimTable& claims) const;
  [[nodiscard]] bool is_left_out(std::size_t part, const MeasuredState& now,
                                 const ClaimTable& claims) const;
  [[nodiscard]] Pose tool_of(std::size_t part, const MeasuredState& state) const;
  void note_goal(std::size_t part, const Setpoint& row, Switch switched,
                 const MeasuredState& before, const MeasuredState& now);

  const RobotModel& model_;
  const Limits& limits_;
  PartMemories memories_;
  std::uint64_t seen_tick_ = 0;  // of the state before the newest, 0: none
};

}  // namespace fairlead
