// G042, second half: a gripper that held something and lost it.
#pragma once

#include <array>
#include <cstdint>

#include "row_view.hpp"

namespace fairlead {

/// A gripper that stands still short of its target for three ticks holds something. If its opening
/// then goes on towards the same target by more than slip_limit, it has lost it.
class GraspWatch {
 public:
  /// In a new state. `told` is the row that acted on the part before it; of no action: the part
  /// held, and keeps its target.
  Evidence note(const Limits& limits, const MeasuredState& state, std::size_t part,
                const Setpoint& told);
  void forget(std::size_t part) { grips_[part] = Grip{}; }
  void clear() { grips_.fill(Grip{}); }

 private:
  struct Grip {
    double target = unset;          // opening told last; NaN: none
    std::uint32_t still_ticks = 0;  // in a row, short of the target
    bool holds = false;
    double opening = unset;  // when it was seen to hold
  };
  std::array<Grip, max_parts> grips_{};
};

}  // namespace fairlead
