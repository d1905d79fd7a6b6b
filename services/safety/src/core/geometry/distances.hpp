// Distances between the shapes that the geometric checks know: segments, points and boxes. In
// metres; not a number wherever one goes in.
#pragma once

#include <Eigen/Core>

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

/// Smallest distance of two segments, of any length, down to single points.
double segment_distance(const Segment& one, const Segment& other);

/// Smallest distance of a segment from a box; where it reaches into it, how deep it lies behind the
/// nearest face, negative.
double box_distance(const Segment& segment, const Box& box);

}  // namespace fairlead
