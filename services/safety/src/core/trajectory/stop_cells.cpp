#include "core/trajectory/stop_cells.hpp"

#include <cmath>

namespace fairlead {

Evidence StopCells::certify(const Joints& from, const Joints& to) {
  for (std::size_t j = 0; j < from.size(); ++j) {
    middle_[j] = 0.5 * (from[j] + to[j]);
    half_[j] = 0.5 * std::abs(to[j] - from[j]);
  }
  return certify_cell();
}

// The budget ends what would never end.
Evidence StopCells::certify_cell() {
  std::size_t widest = none;
  Evidence evidence = check_cell(widest);
  if (!evidence.ok() || widest == none) return evidence;
  const double whole = middle_[widest], half = half_[widest];
  half_[widest] = 0.5 * half;
  for (const double side : {-0.5, 0.5}) {
    middle_[widest] = whole + side * half;
    if (evidence.ok()) evidence = certify_cell();
  }
  middle_[widest] = whole;
  half_[widest] = half;
  return evidence;
}

Evidence StopCells::query(const Joints& joints, FramePoses& poses, const DisplacementBound& bound,
                          double share, Clearance& found) {
  const Evidence evidence = budget_.take();
  if (!evidence.ok()) return evidence;
  poses.place(model_, joints);
  return check_.check(poses, before_, bound, share, found);
}

// `widest`: the joint to halve, unless the whole cell is known to be clear.
Evidence StopCells::check_cell(std::size_t& widest) {
  const DisplacementBound bound(model_, half_);
  Clearance clearance;
  Evidence evidence = query(middle_, middle_poses_, bound, 1.0, clearance);
  const Cell cell{middle_, half_, middle_poses_, bound};
  for (std::size_t i = 0; i < clearance.near_count && evidence.ok(); ++i) {
    const auto [shape, margin] = clearance.near[i];
    if (margin >= check_.bound_of(shape, bound)) continue;
    const CellCorner corner = check_.worst_corner(shape, before_, cell);
    if (corner.least() >= 0.0) continue;
    Joints joints = middle_;
    for (std::size_t j = 0; j < joints.size(); ++j) joints[j] += corner.ways[j];
    Clearance there;
    evidence = query(joints, corner_poses_, bound, 0.0, there);
    if (!(corner.least() >= -tolerated)) widest = widest_of(check_.movers_of(shape));
  }
  return evidence;
}

std::size_t StopCells::widest_of(JointSet movers) const {
  std::size_t widest = none;
  double furthest = 0.0;
  for (std::size_t f = 1; f < model_.frames.size(); ++f) {
    const ModelFrame& frame = model_.frames[f];
    const double moves = frame.reach * half_[frame.joint];
    if ((movers & only(frame.joint)) == 0 || !(moves > furthest)) continue;
    furthest = moves;
    widest = frame.joint;
  }
  return widest;
}

}  // namespace fairlead
