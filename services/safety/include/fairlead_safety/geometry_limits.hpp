// The robot's shape and surroundings as the gate file tells them: its tree of links, the capsules
// around them, and where tools, links and base may be. SI units.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "fairlead_safety/fixed.hpp"

namespace fairlead {

inline constexpr std::size_t max_joints = 32;   // commanded joints
inline constexpr std::size_t max_passive = 16;  // measured, never commanded
inline constexpr std::size_t max_measured = max_joints + max_passive;
inline constexpr std::size_t max_links = 64;  // of the robot's description, its root among them
inline constexpr std::size_t no_link = max_links;
inline constexpr std::size_t max_capsules = 48;
inline constexpr std::size_t max_capsule_pairs = 512;
inline constexpr std::size_t max_volumes = 8;
inline constexpr std::size_t max_zones = 8;
inline constexpr std::size_t max_corners = 8;  // of a footprint or a zone

inline constexpr double unset = std::numeric_limits<double>::quiet_NaN();

enum class LinkMotion : std::uint8_t { fixed, turn, slide };

/// How one link hangs on its parent: a placement, then the motion of one measured joint.
struct Link {
  Name name;
  std::size_t parent = no_link;  // index into Kinematics::links, below the link's own
  LinkMotion motion = LinkMotion::fixed;
  std::size_t joint = max_measured;  // index of the measured joint; unused where fixed
  std::array<double, 3> axis{unset, unset, unset};         // unit vector in the link's frame
  std::array<double, 3> translation{unset, unset, unset};  // [m] in the parent's frame
  std::array<double, 4> rotation_xyzw{unset, unset, unset, unset};
};

/// Every link of the robot's description, parents first; links[0] is the root.
struct Kinematics {
  FixedVec<Link, max_links> links;

  /// Index of the link of that name, no_link if there is none.
  [[nodiscard]] std::size_t find(const Name& name) const;
};

/// All points within `radius` of the segment from `a` to `b`, in the link's frame [m].
struct Capsule {
  std::size_t link = no_link;
  std::array<double, 3> a{unset, unset, unset};
  std::array<double, 3> b{unset, unset, unset};
  double radius = unset;
};

/// Indices into CollisionLimits::capsules.
struct CapsulePair {
  std::uint8_t first = max_capsules;
  std::uint8_t second = max_capsules;
};

/// G032: the robot's own shape, and which of its capsules may not come near each other.
struct CollisionLimits {
  FixedVec<Capsule, max_capsules> capsules;
  FixedVec<CapsulePair, max_capsule_pairs> pairs;
  double clearance = unset;  // [m]
  Text source;
};

/// A box along the axes of the root link [m]: tools stay in it, or tools and capsules out of it.
struct Volume {
  Name name;
  bool keep_out = false;
  std::array<double, 3> lower{unset, unset, unset};
  std::array<double, 3> upper{unset, unset, unset};
};

/// G031. At least one volume keeps the tools in.
struct WorkspaceLimits {
  FixedVec<Volume, max_volumes> volumes;
  Text source;
};

using Corner = std::array<double, 2>;  // x, y [m]

/// A convex polygon in odom, counter-clockwise.
struct Zone {
  Name name;
  bool keep_out = false;
  FixedVec<Corner, max_corners> corners;
};

/// G034: where a mobile base may be. Mandatory for a robot with a joint that zones bound.
struct BaseLimits {
  bool present = false;
  std::array<std::size_t, 3> joints{max_joints, max_joints, max_joints};  // x, y, yaw in odom
  Corner yaw_axis{unset, unset};            // where the base turns, in the root link's frame
  FixedVec<Corner, max_corners> footprint;  // convex, counter-clockwise, in the root link's frame
  double reaction_s = unset;                // before braking begins
  // G031, G032: how far a tool that the base carries goes from where it is predicted, and how much
  // nearer two capsules come, while a base joint moves at its velocity limit and until all rests;
  // in proportion where it is slower [m].
  double tool_drift = unset;
  double clearance_drift = unset;
  // x and y of joint_velocity are commanded in odom turned by minus the yaw, not in odom.
  bool against_yaw = false;
  FixedVec<Zone, max_zones> zones;  // at least one keeps the base in
  Text source;

  /// Whether joint_velocity's number of a joint is turned, with that of the base's other slide.
  [[nodiscard]] bool is_turned(std::size_t joint) const {
    return present && against_yaw && (joint == joints[0] || joint == joints[1]);
  }
};

}  // namespace fairlead
