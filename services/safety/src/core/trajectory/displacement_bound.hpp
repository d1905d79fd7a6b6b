// How far things move at most when the joints go from one configuration to another.
#pragma once

#include <algorithm>
#include <array>

#include "core/kinematics/forward_kinematics.hpp"

namespace fairlead {

/// A joint that turns by dq carries a point by at most its distance from the joint's origin times
/// dq, and that distance is never more than the way from joint to joint and on to the point. Added
/// up over the joints between the point and the frame that it is seen from.
class DisplacementBound {
 public:
  DisplacementBound(const RobotModel& model, const Joints& from, const Joints& to);
  /// Each joint goes so far, either way.
  DisplacementBound(const RobotModel& model, const Joints& ways);
  /// Every joint goes as far as in that of both in which it goes further.
  DisplacementBound(const DisplacementBound& one, const DisplacementBound& other);

  /// Of any point at most `extent` from a frame's origin, as seen from `base`, on which the frame
  /// hangs [m].
  [[nodiscard]] double of(std::size_t frame, double extent, std::size_t base = 0) const;
  /// By how much such a point's way differs from what its velocities at the start say, at most [m].
  [[nodiscard]] double bend(std::size_t frame, double extent, std::size_t base = 0) const;
  /// Of two capsules relative to each other.
  [[nodiscard]] double of(const ModelPair& pair) const;
  /// No way of any capsule, tool or pair is longer.
  [[nodiscard]] double longest() const { return longest_; }

 private:
  struct Sums {       // over the joints between a frame and the root
    double turned;    // [rad]
    double leverage;  // the same times each one's distance from the root
    double slid;      // [m]
  };
  template <class Change>
  void add_up(const Change& change);

  const RobotModel& model_;
  double longest_ = 0.0;
  // Not set beyond the model's frames: filling them would take longer than all else.
  std::array<double, max_links> change_;  // of each frame's joint
  std::array<Sums, max_links> sums_;
};

/// Which share of a way a margin covers, 1 at most; what is no number covers none.
inline double clear_fraction(double margin, double way) {
  if (margin >= way) return 1.0;
  return std::max(0.0, std::max(margin, 0.0) / way);
}

}  // namespace fairlead
