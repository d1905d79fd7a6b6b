// G042, second half: a gripper that held something and lost it.
#pragma once

#include <array>
#include <cstdint>

#include "core/modes/commanded_motion.hpp"

namespace fairlead {

/// A gripper that was seen to go towards its target, and then stands still short of it for three
/// ticks, holds something. If its opening then goes on towards the same target by more than
/// slip_limit, it has lost it. A hand that has not begun to move (dead time) holds nothing yet.
class GraspWatch {
 public:
  /// In a new state. `row` is the one that acted on the part before it; of no action: the part
  /// held, and keeps its target.
  Evidence note(const Limits& limits, const MeasuredState& state, std::size_t part,
                const Setpoint& row);
  void forget(std::size_t part) { grips_[part] = Grip{}; }
  void clear() { grips_.fill(Grip{}); }

 private:
  struct Grip {
    double target = unset;          // opening commanded last; NaN: none
    double commanded_at = unset;    // opening when it was
    bool moved = false;             // towards the target since, or something was held before
    std::uint32_t still_ticks = 0;  // in a row after that, short of the target
    bool holds = false;
    double opening = unset;  // when it was seen to hold

    [[nodiscard]] Grip commanded(double new_target, double opening_now) const;
  };
  std::array<Grip, max_parts> grips_{};
};

}  // namespace fairlead
