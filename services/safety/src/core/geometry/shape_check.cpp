#include "core/geometry/shape_check.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace fairlead {
namespace {

void keep_smallest(double& slack, double margin) { slack = std::min(slack, std::max(margin, 0.0)); }

}  // namespace

ShapeCheck::ShapeCheck(const RobotModel& model, JointSet commanded, JointSet guessed)
    : model_(model), commanded_(commanded), guessed_(guessed) {
  for (std::size_t i = 0; i < model.pairs.size(); ++i) {
    if ((model.pairs[i].movers & commanded) == 0) continue;
    (void)pairs_.push_back(static_cast<std::uint16_t>(i));
  }
  if (model.volumes.empty()) return;
  bool keeps_out = false;
  for (const Volume& volume : model.limits.workspace.volumes) keeps_out |= volume.keep_out;
  for (std::size_t i = 0; i < model.tools.size(); ++i)
    if (model.tools[i].present && (model.tools[i].movers & commanded) != 0)
      (void)tools_.push_back(static_cast<std::uint8_t>(i));
  for (std::size_t i = 0; keeps_out && i < model.capsules.size(); ++i)
    if ((model.frames[model.capsules[i].frame].movers & commanded) != 0)
      (void)capsules_.push_back(static_cast<std::uint8_t>(i));
}

double ShapeCheck::bound_of(std::size_t shape, const DisplacementBound& bound) const {
  if (shape < pairs_.size()) return bound.of(model_.pairs[pairs_[shape]]);
  shape -= pairs_.size();
  if (shape < tools_.size()) {
    const ModelPlace& place = model_.tools[tools_[shape]].place;
    return bound.of(place.frame, place.position.norm());
  }
  const ModelCapsule& capsule = model_.capsules[capsules_[shape - tools_.size()]];
  return bound.of(capsule.frame, capsule.extent);
}

JointSet ShapeCheck::movers_of(std::size_t shape) const {
  if (shape < pairs_.size()) return model_.pairs[pairs_[shape]].movers;
  shape -= pairs_.size();
  if (shape < tools_.size()) return model_.tools[tools_[shape]].movers;
  return model_.frames[model_.capsules[capsules_[shape - tools_.size()]].frame].movers;
}

double ShapeCheck::clear_fraction_of(const Clearance& clearance,
                                     const DisplacementBound& bound) const {
  double free = clear_fraction(clearance.others, bound.longest());
  for (std::size_t i = 0; i < clearance.near_count; ++i) {
    const Clearance::Near& near = clearance.near[i];
    free = std::min(free, clear_fraction(near.margin, bound_of(near.shape, bound)));
  }
  return free;
}

Evidence ShapeCheck::check(const FramePoses& poses, const FramePoses& before,
                           const DisplacementBound& bound, double share, Clearance& found) {
  found.others = share * bound.longest();
  found.near_count = 0;
  const Evidence evidence = check_volumes(poses, before, found);
  return evidence.ok() ? check_pairs(poses, before, bound, share, found) : evidence;
}

Evidence ShapeCheck::check_volumes(const FramePoses& poses, const FramePoses& before,
                                   Clearance& found) const {
  std::array<double, max_parts> tools;
  std::array<double, max_capsules> capsules;
  std::fill_n(tools.begin(), tools_.size(), found.others);
  std::fill_n(capsules.begin(), capsules_.size(), found.others);
  Evidence evidence;
  for (std::size_t v = 0; v < model_.volumes.size() && evidence.ok(); ++v) {
    const Volume& volume = model_.limits.workspace.volumes[v];
    for (std::size_t i = 0; i < tools_.size() && evidence.ok(); ++i)
      evidence = volume.keep_out ? keep_tool_out(tools_[i], v, poses, before, tools[i])
                                 : keep_tool_in(tools_[i], v, poses, before, tools[i]);
    for (std::size_t i = 0; i < capsules_.size() && volume.keep_out && evidence.ok(); ++i)
      evidence = keep_capsule_out(capsules_[i], v, poses, before, capsules[i]);
  }
  for (std::size_t i = 0; i < tools_.size(); ++i)
    if (!(tools[i] >= found.others)) found.add(pairs_.size() + i, tools[i]);
  for (std::size_t i = 0; i < capsules_.size(); ++i)
    if (!(capsules[i] >= found.others)) found.add(pairs_.size() + tools_.size() + i, capsules[i]);
  return evidence;
}

Evidence ShapeCheck::keep_tool_in(std::size_t part, std::size_t index, const FramePoses& poses,
                                  const FramePoses& before, double& slack) const {
  const Volume& volume = model_.limits.workspace.volumes[index];
  const std::array<ModelName, 3>& axes = model_.volumes[index].axes;
  const ModelTool& tool = model_.tools[part];
  const Eigen::Vector3d point = tool_at(tool, poses);
  const std::string_view source = model_.limits.workspace.source.view();
  const Excuse excuse = excuse_of(tool.movers, tool_drift_, Excuse::better);
  const double off_by = tool_drift_ + off(deviation_, tool);
  const double off_before = off(deviation_before_, tool);
  for (std::size_t i = 0; i < axes.size(); ++i) {
    const auto axis = static_cast<Eigen::Index>(i);
    const double upper = volume.upper[i] - off_by, lower = volume.lower[i] + off_by;
    const double under = upper - point[axis], over = point[axis] - lower;
    keep_smallest(slack, under);
    keep_smallest(slack, over);
    const Name& name = model_.limits.parts[part].name;
    const auto was = [&](const FramePoses& in) { return tool_at(tool, in)[axis]; };
    const auto under_before = [&](const FramePoses& in) {
      return volume.upper[i] - off_before - was(in);
    };
    const auto over_before = [&](const FramePoses& in) {
      return was(in) - volume.lower[i] - off_before;
    };
    if (is_at_fault(under, before, excuse, under_before))
      return of(above(code::workspace, axes[i].view(), point[axis], upper, "m", source), name);
    if (is_at_fault(over, before, excuse, over_before))
      return of(below(code::workspace, axes[i].view(), point[axis], lower, "m", source), name);
  }
  return {};
}

Evidence ShapeCheck::keep_tool_out(std::size_t part, std::size_t volume, const FramePoses& poses,
                                   const FramePoses& before, double& slack) const {
  const Box box = box_of(model_.limits.workspace.volumes[volume]);
  const auto distance_of = [&](const FramePoses& in) {
    const Eigen::Vector3d point = tool_at(model_.tools[part], in);
    return box_distance({point, point}, box);
  };
  const ModelTool& tool = model_.tools[part];
  const double distance = distance_of(poses) - tool_drift_ - off(deviation_, tool);
  keep_smallest(slack, distance);
  const Excuse excuse = excuse_of(tool.movers, tool_drift_, Excuse::better);
  const auto margin_before = [&](const FramePoses& in) {
    return distance_of(in) - off(deviation_before_, tool);
  };
  if (!is_at_fault(distance, before, excuse, margin_before)) return {};
  return of(below(code::workspace, model_.volumes[volume].tool.view(), distance, 0.0, "m",
                  model_.limits.workspace.source.view()),
            model_.limits.parts[part].name);
}

Evidence ShapeCheck::keep_capsule_out(std::size_t capsule, std::size_t volume,
                                      const FramePoses& poses, const FramePoses& before,
                                      double& slack) const {
  const Box box = box_of(model_.limits.workspace.volumes[volume]);
  const ModelCapsule& shape = model_.capsules[capsule];
  const Eigen::Vector3d middle = point_in_root(poses[shape.frame], shape.middle);
  const double off_by = tool_drift_ + off(deviation_, shape);
  if (box_distance({middle, middle}, box) - shape.reach - off_by >= slack) return {};
  const auto margin_of = [&](const FramePoses& in) {
    return box_distance(segment(capsule, in), box) - shape.radius;
  };
  const double margin = margin_of(poses) - off_by;
  keep_smallest(slack, margin);
  const JointSet movers = model_.frames[shape.frame].movers;
  const Excuse excuse = excuse_of(movers, tool_drift_, Excuse::better);
  const auto margin_before = [&](const FramePoses& in) {
    return margin_of(in) - off(deviation_before_, shape);
  };
  if (!is_at_fault(margin, before, excuse, margin_before)) return {};
  return of_part_that_moves(below(code::workspace, model_.volumes[volume].capsules[capsule].view(),
                                  margin, 0.0, "m", model_.limits.workspace.source.view()),
                            movers);
}

Segment ShapeCheck::segment(std::size_t capsule, const FramePoses& poses) const {
  const ModelCapsule& shape = model_.capsules[capsule];
  return {point_in_root(poses[shape.frame], shape.a), point_in_root(poses[shape.frame], shape.b)};
}

double ShapeCheck::pair_distance(const ModelPair& pair, const FramePoses& poses) const {
  return segment_distance(segment(pair.first, poses), segment(pair.second, poses)) -
         model_.capsules[pair.first].radius - model_.capsules[pair.second].radius;
}

// Most pairs are so far apart that the spheres around them tell. A distance that is no number is a
// hit.
Evidence ShapeCheck::check_pairs(const FramePoses& poses, const FramePoses& before,
                                 const DisplacementBound& bound, double share, Clearance& found) {
  if (pairs_.empty()) return {};
  std::array<Eigen::Vector3d, max_capsules> middles;
  for (std::size_t i = 0; i < model_.capsules.size(); ++i)
    middles[i] = point_in_root(poses[model_.capsules[i].frame], model_.capsules[i].middle);
  const double clearance = model_.limits.collision.clearance + clearance_drift_;
  const double longest_off = deviation_ ? deviation_->longest() : 0.0;
  for (std::size_t i = 0; i < pairs_.size(); ++i) {
    const ModelPair& pair = model_.pairs[pairs_[i]];
    const double apart = (middles[pair.first] - middles[pair.second]).squaredNorm();
    const auto are_clear_by = [&](double margin) {
      const double near = pair.near + clearance_drift_ + margin;
      return apart >= near * near;
    };
    if (are_clear_by(found.others + longest_off)) continue;
    const double need = share * bound.of(pair);
    const double off_by = off(deviation_, pair);
    if (are_clear_by(need + off_by)) {
      found.add(i, need);
      continue;
    }
    const double distance = pair_distance(pair, poses) - off_by;
    found.add(i, distance - clearance);
    const auto margin_before = [&](const FramePoses& in) {
      return pair_distance(pair, in) - clearance - off(deviation_before_, pair);
    };
    const Excuse excuse = excuse_of(pair.movers, clearance_drift_, Excuse::none);
    if (!is_at_fault(distance - clearance, before, excuse, margin_before)) continue;
    return of_part_that_moves(below(code::collision, model_.pair_names[pairs_[i]].view(), distance,
                                    clearance, "m", model_.limits.collision.source.view()),
                              pair.movers);
  }
  return {};
}

Evidence ShapeCheck::of_part_that_moves(Evidence evidence, JointSet movers) const {
  for (const PartLimits& part : model_.limits.parts)  // GCOVR_EXCL_BR_LINE: one does
    for (const std::size_t j : part.joints)
      if ((movers & commanded_ & only(j)) != 0) return of(evidence, part.name);
  return evidence;  // GCOVR_EXCL_LINE: only what a commanded joint of some part moves is looked at
}

}  // namespace fairlead
