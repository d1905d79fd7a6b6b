#include "core/kinematics/robot_model.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/geometry/distances.hpp"
#include "core/modes/commanded_motion.hpp"

namespace fairlead {
namespace {

Eigen::Matrix3d matrix(const std::array<double, 4>& q) {
  return Eigen::Quaterniond(q[3], q[0], q[1], q[2]).toRotationMatrix();
}

ModelPlace compose(const ModelPlace& parent, const Link& link) {
  return {parent.frame, parent.rotation * matrix(link.rotation_xyzw),
          parent.position + parent.rotation * vector(link.translation)};
}

// Rodrigues' formula, the parts that do not depend on the angle taken out.
ModelFrame moving_frame(const ModelPlace& at_zero, const Link& link, JointSet parent_movers) {
  ModelFrame frame;
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

ModelPlace at_origin_of(std::size_t frame) {
  return {frame, Eigen::Matrix3d::Identity(), Eigen::Vector3d::Zero()};
}

void add_frames(RobotModel& model) {
  (void)model.frames.push_back(ModelFrame{});
  model.places[0] = at_origin_of(0);
  const auto& links = model.limits.kinematics.links;
  for (std::size_t i = 1; i < links.size(); ++i) {
    const ModelPlace place = compose(model.places[links[i].parent], links[i]);
    model.places[i] = place;
    if (links[i].motion == LinkMotion::fixed) continue;
    model.places[i] = at_origin_of(model.frames.size());
    model.frames[place.frame].children |= FrameSet{1} << model.frames.size();
    (void)model.frames.push_back(moving_frame(place, links[i], model.frames[place.frame].movers));
  }
}

void add_capsules(RobotModel& model) {
  for (const Capsule& shape : model.limits.collision.capsules) {
    const ModelPlace& place = model.places[shape.link];
    ModelCapsule capsule;
    capsule.frame = place.frame;
    capsule.a = place.position + place.rotation * vector(shape.a);
    capsule.b = place.position + place.rotation * vector(shape.b);
    capsule.middle = 0.5 * (capsule.a + capsule.b);
    capsule.radius = shape.radius;
    capsule.reach = 0.5 * (capsule.b - capsule.a).norm() + shape.radius;
    capsule.extent = std::max(capsule.a.norm(), capsule.b.norm());
    (void)model.capsules.push_back(capsule);
  }
}

ModelName name_of(std::string_view one, std::string_view other) {
  ModelName name(one);
  return name.append(" / ").append(other);
}

std::string_view link_of(const RobotModel& model, std::size_t capsule) {
  return model.limits.kinematics.links[model.limits.collision.capsules[capsule].link].name.view();
}

// Parents come first, so of two frames the later one is never between the other and the root.
std::uint8_t common_frame(const RobotModel& model, std::size_t one, std::size_t other) {
  while (one != other) {
    const std::size_t earlier = std::min(one, other);
    other = model.frames[std::max(one, other)].parent;
    one = earlier;
  }
  return static_cast<std::uint8_t>(one);
}

void add_pairs(RobotModel& model) {
  for (const CapsulePair& pair : model.limits.collision.pairs) {
    const std::size_t frame = model.capsules[pair.first].frame;
    const std::size_t other_frame = model.capsules[pair.second].frame;
    const JointSet one = model.frames[frame].movers;
    const JointSet other = model.frames[other_frame].movers;
    const double near = model.capsules[pair.first].reach + model.capsules[pair.second].reach +
                        model.limits.collision.clearance;
    (void)model.pairs.push_back(
        {pair.first, pair.second, common_frame(model, frame, other_frame), {}, one ^ other, near});
    (void)model.pair_names.push_back(
        name_of(link_of(model, pair.first), link_of(model, pair.second)));
  }
}

void add_volumes(RobotModel& model) {
  for (const Volume& volume : model.limits.workspace.volumes) {
    ModelVolume names;
    for (std::size_t i = 0; i < model.capsules.size() && volume.keep_out; ++i)
      names.capsules[i] = name_of(link_of(model, i), volume.name.view());
    names.tool = name_of("tool", volume.name.view());
    names.axes = {name_of("tool x", volume.name.view()), name_of("tool y", volume.name.view()),
                  name_of("tool z", volume.name.view())};
    (void)model.volumes.push_back(names);
  }
}

// Frames from the root to one that carries a tool, root side first.
void add_chain(const RobotModel& model, const PartLimits& part, std::size_t frame,
               ModelTool& tool) {
  if (frame == 0) return;
  add_chain(model, part, model.frames[frame].parent, tool);
  (void)tool.chain.push_back(static_cast<std::uint8_t>(frame));
  if (part.joints.contains(model.frames[frame].joint))
    (void)tool.own.push_back(static_cast<std::uint8_t>(frame));
}

void add_tools(RobotModel& model) {
  for (std::size_t i = 0; i < model.limits.parts.size(); ++i) {
    const PartLimits& part = model.limits.parts[i];
    for (const std::size_t joint : part.joints) model.part_joints[i] |= only(joint);
    if (part.tool == no_link) continue;
    ModelTool& tool = model.tools[i];
    tool.present = true;
    tool.place = model.places[part.tool];
    tool.movers = model.frames[tool.place.frame].movers;
    add_chain(model, part, tool.place.frame, tool);
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
void add_reach(RobotModel& model) {
  std::array<double, max_links> extent{};
  const auto extend = [&](std::size_t frame, double distance) {
    extent[frame] = larger(extent[frame], distance);
  };
  for (const ModelCapsule& capsule : model.capsules) extend(capsule.frame, capsule.extent);
  for (const ModelTool& tool : model.tools) extend(tool.place.frame, tool.place.position.norm());
  for (std::size_t f = model.frames.size() - 1; f > 0; --f) {
    ModelFrame& frame = model.frames[f];
    frame.reach = frame.turns ? extent[f] : 1.0;
    extend(frame.parent, frame.distance - model.frames[frame.parent].distance + extent[f]);
  }
  for (ModelTool& tool : model.tools)
    for (const std::uint8_t f : tool.own)
      if (model.frames[f].turns) tool.reach = larger(tool.reach, model.frames[f].reach);
}

void add_distances(RobotModel& model) {
  for (std::size_t f = 1; f < model.frames.size(); ++f) {
    ModelFrame& frame = model.frames[f];
    const double slid = frame.turns ? 0.0 : travel(model.limits, frame.joint);
    frame.distance = model.frames[frame.parent].distance + frame.origin.norm() + slid;
  }
}

}  // namespace

RobotModel::RobotModel(const Limits& robot_limits) : limits(robot_limits) {
  period_s = static_cast<double>(limits.period_ns) * 1e-9;
  for (std::size_t j = 0; j < limits.joints.size(); ++j) fastest[j] = fastest_command(limits, j);
  add_frames(*this);
  for (const ModelFrame& frame : frames) tree_joints |= frame.movers;
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
