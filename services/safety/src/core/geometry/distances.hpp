// Distances between the shapes that the geometric checks know: segments, points and boxes. In
// metres; not a number wherever one goes in. And when a row is at fault for such a distance.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstdint>

namespace fairlead {

/// Between two points that stand for the segment between them.
struct Segment {
  Eigen::Vector3d a;
  Eigen::Vector3d b;
};

/// An axis-aligned box.
struct Box {
  Eigen::Vector3d lower;
  Eigen::Vector3d upper;
};

/// From the nearest point of `other` to that of `one`; of any length, down to single points.
Eigen::Vector3d segment_gap(const Segment& one, const Segment& other);
/// From the nearest point of a box to that of a segment, or square to the face that it is nearest
/// to have left; of length 1.
Eigen::Vector3d box_direction(const Segment& segment, const Box& box);

/// Smallest distance of two segments.
inline double segment_distance(const Segment& one, const Segment& other) {
  return segment_gap(one, other).norm();
}

/// Smallest distance of a segment from a box; where it reaches into it, how deep it lies behind the
/// nearest face, negative.
double box_distance(const Segment& segment, const Box& box);

// What two computations of the same distance may differ by [m, or of a singular value].
inline constexpr double unchanged = 1e-6;

/// What a row that finds a limit broken may do: not act, leave it better, or leave it as it is too.
enum class Excuse : std::uint8_t { none, better, as_it_is };

/// A margin is what is left to a limit, negative beyond it. Where it was negative before the row
/// already, the row may leave it as `excuse` says. `margin_before()` is asked beyond it only.
template <class Before>
bool is_breach(double margin, const Before& margin_before, Excuse excuse = Excuse::as_it_is) {
  if (margin >= 0.0) return false;
  if (excuse == Excuse::none) return true;
  const double before = margin_before();
  const double least = excuse == Excuse::better ? before + unchanged : before - unchanged;
  return !(before < 0.0 && margin >= least);
}

/// std::min and std::max drop a second argument that is no number, and keep a first.
inline double smaller(double a, double b) { return std::isnan(a) ? a : std::min(b, a); }
inline double larger(double a, double b) { return std::isnan(a) ? a : std::max(b, a); }

}  // namespace fairlead
