// Is it said where the robot may be: boxes for its tools and links, and zones for its base?

#include "core/limits/validation_text.hpp"

namespace fairlead {
namespace {

template <class List>
bool keeps_in(const List& places) {
  for (const auto& place : places)
    if (!place.keep_out) return true;
  return false;
}

Text check_volume(const Volume& volume) {
  if (volume.name.empty()) return "workspace.volumes: a volume without a name";
  const Text key = phrase("workspace.volumes.", volume.name);
  return first_of({check_range(phrase(key, " x"), volume.lower[0], volume.upper[0]),
                   check_range(phrase(key, " y"), volume.lower[1], volume.upper[1]),
                   check_range(phrase(key, " z"), volume.lower[2], volume.upper[2])});
}

// Twice the area of the triangle a, b, c: above 0 where c lies to the left of the way from a to b.
double turn(const Corner& a, const Corner& b, const Corner& c) {
  return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

using Corners = FixedVec<Corner, max_corners>;

// Every corner lies to the left of every side that it is no end of. One side needs no look: what is
// closed by all the others is closed by it.
bool is_convex(const Corners& corners) {
  const std::size_t count = corners.size();
  for (std::size_t i = 1; i < count; ++i)
    for (std::size_t k = 2; k < count; ++k)
      if (!(turn(corners[i], corners[(i + 1) % count], corners[(i + k) % count]) > 0.0))
        return false;
  return true;
}

Text check_corners(const Text& key, const Corners& corners) {
  for (std::size_t i = 0; i < corners.size(); ++i)
    if (!all_finite(corners[i])) return phrase(key, "[", i, "]: expected finite numbers");
  if (corners.size() >= 3 && is_convex(corners)) return {};
  return phrase(key, ": expected 3 or more corners of a convex polygon, counter-clockwise, got ",
                corners.size(), " that are none");
}

Text check_zone(const Zone& zone) {
  if (zone.name.empty()) return "base.zones: a zone without a name";
  return check_corners(phrase("base.zones.", zone.name, ".corners"), zone.corners);
}

// x and y slide, yaw turns.
Text check_base_joints(const Limits& limits) {
  const auto& joints = limits.base.joints;
  for (std::size_t i = 0; i < joints.size(); ++i) {
    if (joints[i] >= limits.joints.size()) return "base.joints: no such joint";
    const JointLimits& joint = limits.joints[joints[i]];
    if ((i < 2) != (joint.kind == JointKind::prismatic))
      return phrase("base.joints: expected two that slide and one that turns, got ", joint.name);
  }
  const auto& [x, y, yaw] = joints;
  if (x != y) return {};
  return phrase("base.joints: ", limits.joints[x].name, " is there twice");
}

// A twist is predicted and measured by the base's own joints, and a floor is flat.
Text check_twists(const Limits& limits) {
  const auto& [x, y, yaw] = limits.base.joints;
  for (const PartLimits& part : limits.parts) {
    const CartesianLimits& mode = part.modes.body_twist;
    if (!mode.supported) continue;
    const Text key = phrase("parts.", part.name, ".modes.body_twist");
    const auto& own = part.joints;
    if (own.size() != 3 || own[0] != x || own[1] != y || own[2] != yaw)
      return phrase(key, ": expected a part of base.joints, in their order");
    if (mode.free_axes[2] || mode.free_axes[3] || mode.free_axes[4])
      return phrase(key, ".free_axes: expected none but 0, 1 and 5");
  }
  return {};
}

// No bounds of its own, so nothing but the base's zones can bound it, if it is no joint that turns
// without end.
Text check_unbounded(const Limits& limits) {
  for (std::size_t j = 0; j < limits.joints.size(); ++j) {
    const auto& [x, y, yaw] = limits.base.joints;
    const bool zoned = limits.base.present && (j == x || j == y || j == yaw);
    const bool endless = limits.joints[j].kind == JointKind::continuous;
    if (!limits.joints[j].bounded && !endless && !zoned)
      return phrase("base: expected zones for joint ", limits.joints[j].name,
                    ", which has no bounds");
  }
  return {};
}

}  // namespace

Text check_workspace(const Limits& limits) {
  const auto& volumes = limits.workspace.volumes;
  Text fault = check_names(volumes, "workspace.volumes");
  for (const Volume& volume : volumes)
    if (fault.empty()) fault = check_volume(volume);
  if (!fault.empty() || keeps_in(volumes) || !has_tool(limits)) return fault;
  return "workspace.volumes: expected one of kind keep_in, got none, and there is a tool";
}

Text check_base(const Limits& limits) {
  const BaseLimits& base = limits.base;
  if (const Text fault = check_unbounded(limits); !fault.empty() || !base.present) return fault;
  if (!all_finite(base.yaw_axis)) return "base.yaw_axis: expected finite numbers";
  Text fault = first_of({check_base_joints(limits), check_twists(limits),
                         check_corners("base.footprint", base.footprint),
                         positive("base.reaction_s", base.reaction_s),
                         not_negative("base.tool_drift", base.tool_drift),
                         not_negative("base.clearance_drift", base.clearance_drift),
                         check_names(base.zones, "base.zones")});
  for (const Zone& zone : base.zones)
    if (fault.empty()) fault = check_zone(zone);
  if (!fault.empty() || keeps_in(base.zones)) return fault;
  return "base.zones: expected one of kind keep_in, got none";
}

}  // namespace fairlead
