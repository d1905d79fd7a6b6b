#include "core/kinematics/robot_model.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/geometry/margin.hpp"
#include "core/modes/commanded_motion.hpp"

namespace fairlead {
namespace {

Eigen::Matrix3d matrix(const std::array<double, 4>& q) {
  return Eigen::Quaterniond(q[3], q[0], q[1], q[2]).toRotationMatrix();
}

PlanPlace compose(const PlanPlace& parent, const Link& link) {
  return {parent.frame, parent.rotation * matrix(link.rotation_xyzw),
          parent.position + parent.rotation * vector(link.translation)};
}

// Rodrigues' formula, the parts that do not depend on the angle taken out.
PlanFrame moving_frame(const PlanPlace& at_zero, const Link& link, JointSet parent_movers) {
  PlanFrame frame;
  const Eigen::Vector3d axis = vector(link.axis);
  frame.parent = at_zero.frame;
  frame.joint = link.joint;
  frame.turns = link.motion == LinkMotion::turn;
  frame.origin = at_zero.position;
  frame.axis = axis;
  frame.movers = parent_movers | only(link.joint);
  frame.still = at_zero.rotation;
  if (!frame.turns) {
    frame.slide = at_zero.rotation * axis;
    return frame;
  }
  Eigen::Matrix3d across;
  across << 0.0, -axis.z(), axis.y(), axis.z(), 0.0, -axis.x(), -axis.y(), axis.x(), 0.0;
  const Eigen::Matrix3d along = axis * axis.transpose();
  frame.still = at_zero.rotation * along;
  frame.cosine = at_zero.rotation * (Eigen::Matrix3d::Identity() - along);
  frame.sine = at_zero.rotation * across;
  return frame;
}

void add_frames(PathPlan& plan) {
  (void)plan.frames.push_back(PlanFrame{});
  const auto& links = plan.limits.kinematics.links;
  for (std::size_t i = 1; i < links.size(); ++i) {
    const PlanPlace place = compose(plan.places[links[i].parent], links[i]);
    plan.places[i] = place;
    if (links[i].motion == LinkMotion::fixed) continue;
    plan.places[i] = PlanPlace{};
    plan.places[i].frame = plan.frames.size();
    plan.frames[place.frame].children |= FrameSet{1} << plan.frames.size();
    (void)plan.frames.push_back(moving_frame(place, links[i], plan.frames[place.frame].movers));
  }
}

void add_capsules(PathPlan& plan) {
  for (const Capsule& shape : plan.limits.collision.capsules) {
    const PlanPlace& place = plan.places[shape.link];
    PlanCapsule capsule;
    capsule.frame = place.frame;
    capsule.a = place.position + place.rotation * vector(shape.a);
    capsule.b = place.position + place.rotation * vector(shape.b);
    capsule.middle = 0.5 * (capsule.a + capsule.b);
    capsule.radius = shape.radius;
    capsule.reach = 0.5 * (capsule.b - capsule.a).norm() + shape.radius;
    capsule.extent = std::max(capsule.a.norm(), capsule.b.norm());
    (void)plan.capsules.push_back(capsule);
  }
}

PlanName name_of(std::string_view one, std::string_view other) {
  PlanName name(one);
  return name.append(" / ").append(other);
}

std::string_view link_of(const PathPlan& plan, std::size_t capsule) {
  return plan.limits.kinematics.links[plan.limits.collision.capsules[capsule].link].name.view();
}

// Parents come first, so of two frames the later one is never between the other and the root.
std::uint8_t common_frame(const PathPlan& plan, std::size_t one, std::size_t other) {
  while (one != other) {
    const std::size_t earlier = std::min(one, other);
    other = plan.frames[std::max(one, other)].parent;
    one = earlier;
  }
  return static_cast<std::uint8_t>(one);
}

void add_pairs(PathPlan& plan) {
  for (const CapsulePair& pair : plan.limits.collision.pairs) {
    const std::size_t frame = plan.capsules[pair.first].frame;
    const std::size_t other_frame = plan.capsules[pair.second].frame;
    const JointSet one = plan.frames[frame].movers;
    const JointSet other = plan.frames[other_frame].movers;
    const double near = plan.capsules[pair.first].reach + plan.capsules[pair.second].reach +
                        plan.limits.collision.clearance;
    (void)plan.pairs.push_back(
        {pair.first, pair.second, common_frame(plan, frame, other_frame), {}, one ^ other, near});
    (void)plan.pair_names.push_back(name_of(link_of(plan, pair.first), link_of(plan, pair.second)));
  }
}

void add_volumes(PathPlan& plan) {
  for (const Volume& volume : plan.limits.workspace.volumes) {
    PlanVolume names;
    for (std::size_t i = 0; i < plan.capsules.size() && volume.keep_out; ++i)
      names.capsules[i] = name_of(link_of(plan, i), volume.name.view());
    names.tool = name_of("tool", volume.name.view());
    names.axes = {name_of("tool x", volume.name.view()), name_of("tool y", volume.name.view()),
                  name_of("tool z", volume.name.view())};
    (void)plan.volumes.push_back(names);
  }
}

// Frames from the root to one that carries a tool, root side first.
void add_chain(const PathPlan& plan, const PartLimits& part, std::size_t frame, PlanTool& tool) {
  if (frame == 0) return;
  add_chain(plan, part, plan.frames[frame].parent, tool);
  (void)tool.chain.push_back(static_cast<std::uint8_t>(frame));
  if (part.joints.contains(plan.frames[frame].joint))
    (void)tool.own.push_back(static_cast<std::uint8_t>(frame));
}

void add_tools(PathPlan& plan) {
  for (std::size_t i = 0; i < plan.limits.parts.size(); ++i) {
    const PartLimits& part = plan.limits.parts[i];
    for (const std::size_t joint : part.joints) plan.part_joints[i] |= only(joint);
    if (part.tool == no_link) continue;
    PlanTool& tool = plan.tools[i];
    tool.present = true;
    tool.place = plan.places[part.tool];
    tool.movers = plan.frames[tool.place.frame].movers;
    add_chain(plan, part, tool.place.frame, tool);
  }
}

// How far the position of a slide can take what it carries [m]. One without bounds: further than
// anything is looked at; a number all the same, or what is beside it would take its place.
double travel(const Limits& limits, std::size_t joint) {
  constexpr double endless = 1e6;
  const bool commanded = joint < limits.joints.size();
  if (commanded && !limits.joints[joint].bounded) return endless;
  const Bounds& bounds = commanded ? limits.joints[joint].bounds
                                   : limits.passive_joints[joint - limits.joints.size()].bounds;
  return std::max(-bounds.lower, bounds.upper) + bounds.tolerance;
}

// From the tips to the root: what hangs on each frame reaches at most so far from its origin.
void add_reach(PathPlan& plan) {
  std::array<double, max_links> extent{};
  const auto extend = [&](std::size_t frame, double distance) {
    extent[frame] = larger(extent[frame], distance);
  };
  for (const PlanCapsule& capsule : plan.capsules) extend(capsule.frame, capsule.extent);
  for (const PlanTool& tool : plan.tools) extend(tool.place.frame, tool.place.position.norm());
  for (std::size_t f = plan.frames.size() - 1; f > 0; --f) {
    PlanFrame& frame = plan.frames[f];
    frame.reach = frame.turns ? extent[f] : 1.0;
    extend(frame.parent, frame.distance - plan.frames[frame.parent].distance + extent[f]);
  }
  for (PlanTool& tool : plan.tools)
    for (const std::uint8_t f : tool.own)
      if (plan.frames[f].turns) tool.reach = larger(tool.reach, plan.frames[f].reach);
}

void add_distances(PathPlan& plan) {
  for (std::size_t f = 1; f < plan.frames.size(); ++f) {
    PlanFrame& frame = plan.frames[f];
    const double slid = frame.turns ? 0.0 : travel(plan.limits, frame.joint);
    frame.distance = plan.frames[frame.parent].distance + frame.origin.norm() + slid;
  }
}

}  // namespace

PathPlan::PathPlan(const Limits& robot_limits) : limits(robot_limits) {
  period_s = static_cast<double>(limits.period_ns) * 1e-9;
  for (std::size_t j = 0; j < limits.joints.size(); ++j) fastest[j] = fastest_told(limits, j);
  add_frames(*this);
  for (const PlanFrame& frame : frames) tree_joints |= frame.movers;
  add_capsules(*this);
  add_pairs(*this);
  add_volumes(*this);
  add_tools(*this);
  add_distances(*this);
  add_reach(*this);
  for (const Corner& corner : limits.base.footprint) {
    const double x = corner[0] - limits.base.yaw_axis[0], y = corner[1] - limits.base.yaw_axis[1];
    base_extent = std::max(base_extent, std::hypot(x, y));
  }
  if (!limits.base.present) return;
  for (const std::size_t joint : limits.base.joints) base_joints |= only(joint);
}

}  // namespace fairlead
