// G041: a joint that is told to move and whose measured position does not change.
#pragma once

#include <array>
#include <cstdint>

#include "motion_view.hpp"

namespace fairlead {

/// Counts, per joint and per part, the ticks in a row in which commanded motion changed nothing.
/// In contact a joint may press without moving; it is stuck only if the measurement rests within
/// `encoder_step`, which a live sensor's noise exceeds.
class StuckWatch {
 public:
  /// A row acted on its part between the two states of the view.
  Evidence after_row(const MotionView& view);
  /// No row acted on the part, or none that is known.
  void after_hold(const Limits& limits, std::size_t part);
  void clear();

 private:
  Evidence after_joint_row(const MotionView& view);

  std::array<std::uint32_t, max_joints> joint_ticks_{};  // modes that command joints one by one
  std::array<std::uint32_t, max_parts> part_ticks_{};    // modes that move all joints of a part
};

}  // namespace fairlead
