// G041: a joint that is commanded to move and whose measured position does not change.
#pragma once

#include <array>
#include <cstdint>

#include "core/kinematics/forward_kinematics.hpp"
#include "core/monitor/motion_view.hpp"

namespace fairlead {

/// What may be commanded without anything having to move. Of one joint `linear`, in its own unit.
struct DeadBand {
  double linear = unset;   // [m]
  double angular = unset;  // [rad]

  [[nodiscard]] bool exceeded_by(double far, double turned) const;
};

/// Adds up, per joint and per part, what it was commanded to move since its measured position last
/// changed by more than `encoder_step`. Nothing but such a change begins anew: not a hold, not
/// another mode, not a row that leaves the joint alone. In contact a joint may press without
/// moving; it is stuck only if the measurement rests, which a live sensor's noise does not.
class StuckWatch {
 public:
  /// A new state, before its rows.
  void note_state(const Limits& limits, const MeasuredState& state);
  /// A row acted on its part between the two states of the view.
  Evidence after_row(const MotionView& view);
  void clear();

 private:
  struct Commanded {
    std::uint32_t rows = 0;  // that commanded it to move
    Twist sum{};             // of the commanded motions, and how far from rest that was at most
    double linear = 0.0;
    double angular = 0.0;

    void add(const Twist& motion);
    void reach(double far, double turned = 0.0);
    [[nodiscard]] bool beyond(const DeadBand& dead_band, std::uint32_t rows_needed) const;
  };
  struct Joint {
    double position = unset;  // at the last change; NaN: none seen
    bool changed = false;     // in the newest state
    Commanded commanded;      // by modes that command joints one by one, in `linear`
  };
  Evidence after_joint_row(const MotionView& view);
  void add_joint(const MotionView& view, std::size_t joint);
  void add_part(const MotionView& view);
  [[nodiscard]] Evidence stuck(const MotionView& view, std::size_t joint,
                               std::string_view rule) const;

  std::array<Joint, max_joints> joints_{};
  std::array<Commanded, max_parts> parts_{};  // by modes that move all joints of a part
};

}  // namespace fairlead
