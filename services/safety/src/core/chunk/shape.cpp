// Structural checks of a chunk: sizes first, finiteness second, addressing third.
// Nothing here reads a number before its place in the block is known to exist.

#include <cmath>

#include "core/chunk/judgement.hpp"
#include "fairlead_safety/limits.hpp"

namespace fairlead {
namespace {

constexpr double largest_magnitude = 1e6;

// G007: the horizon is within the claim's, and every block is exactly horizon x width.
Evidence check_sizes(const Limits& limits, const ClaimLimits& claim, const ActionChunk& chunk) {
  if (chunk.horizon < 1)
    return below(code::shape, "horizon", chunk.horizon, 1, "rows", "a chunk has at least one row");
  if (chunk.horizon > claim.horizon_max || chunk.horizon > max_rows)
    return above(code::shape, "horizon", chunk.horizon, claim.horizon_max, "rows",
                 "the claim's horizon_max");
  if (chunk.parts.empty()) return broken_rule(code::shape, "parts", "at least one part");
  for (const ActionPart& action : chunk.parts) {
    const PartLimits& part = limits.parts[action.part];
    const std::size_t width = mode_width(action.mode, limits.joints.size());
    // The row stride is the mode's width, never the robot's dof. A mode without one has no checker
    // either: nothing of it is read, and G009 refuses it.
    if (width == 0) continue;
    const std::size_t expected = std::size_t{chunk.horizon} * width;  // at most 64 x 32
    if (action.values.size() != expected)
      return of(
          broken_rule(code::shape, "values", "horizon x width of the mode",
                      static_cast<double>(action.values.size()), static_cast<double>(expected)),
          part.name);
  }
  // The tick after the last row counts too: it is where a release ends.
  if (chunk.start_tick > UINT64_MAX - chunk.horizon)
    return broken_rule(code::shape, "start_tick", "ticks that fit 64 bits, with the one after",
                       static_cast<double>(chunk.start_tick));
  return {};
}

// G008: every number of every row, past ones too, is finite and small enough to calculate with.
// Also beside a part whose mode is unknown: that one is refused, this one stops.
Evidence check_numbers(const Limits& limits, const ActionChunk& chunk) {
  for (const ActionPart& action : chunk.parts) {
    const std::size_t width = mode_width(action.mode, limits.joints.size());
    if (width == 0) continue;
    for (std::size_t i = 0; i < action.values.size(); ++i) {
      const double value = action.values[i];
      const bool too_low = value < -largest_magnitude;
      if (!too_low && value <= largest_magnitude) continue;  // false for NaN
      constexpr std::string_view rule = "every value is finite and at most 1e6";
      const std::string_view mode = mode_name(action.mode);
      Evidence evidence = too_low ? below(code::finite, mode, value, -largest_magnitude, "1", rule)
                                  : above(code::finite, mode, value, largest_magnitude, "1", rule);
      evidence.raises_stop = true;  // a policy that emits this is broken, not merely wrong
      return at(evidence, static_cast<std::int64_t>(i / width), limits.parts[action.part].name);
    }
  }
  return {};
}

// G009, joint modes: the mask names joints of this part, ascending, and the rest is exactly zero.
Evidence check_mask(const Limits& limits, const PartLimits& part, const ActionChunk& chunk,
                    const ActionPart& action) {
  if (action.active.empty())
    return broken_rule(code::addressing, "active", "the joints that it commands");
  std::array<bool, max_joints> commanded{};
  for (std::size_t i = 0; i < action.active.size(); ++i) {
    const std::uint8_t joint = action.active[i];
    if (i > 0 && joint <= action.active[i - 1])
      return broken_rule(code::addressing, "active", "ascending joints, each once", joint,
                         action.active[i - 1]);
    if (!part.joints.contains(joint))
      return broken_rule(code::addressing,
                         joint < limits.joints.size() ? limits.joints[joint].name.view() : "active",
                         "a joint of this part", joint);
    commanded[joint] = true;
  }
  const BaseLimits& base = limits.base;
  if (base.is_turned(base.joints[0]) && commanded[base.joints[0]] != commanded[base.joints[1]])
    return broken_rule(code::addressing, "active", "both slides of its base, or neither");
  for (std::size_t row = 0; row < chunk.horizon; ++row)
    for (std::size_t joint = 0; joint < limits.joints.size(); ++joint) {
      const double value = action.values[row * limits.joints.size() + joint];
      if (!commanded[joint] && value != 0.0)
        return at(broken_rule(code::addressing, limits.joints[joint].name.view(),
                              "0.0 where not active", value),
                  static_cast<std::int64_t>(row), part.name);
    }
  return {};
}

// G009: nothing along axes the part does not have.
Evidence check_axes(const CartesianLimits& mode, const ActionChunk& chunk,
                    const ActionPart& action) {
  constexpr std::array<std::string_view, 6> axes{"x", "y", "z", "rx", "ry", "rz"};
  for (std::size_t row = 0; row < chunk.horizon; ++row)
    for (std::size_t axis = 0; axis < axes.size(); ++axis) {
      const double value = action.values[row * axes.size() + axis];
      if (mode.free_axes[axis] || value == 0.0) continue;
      Evidence evidence =
          broken_rule(code::addressing, axes[axis], "0.0 along an axis that is not free", value);
      evidence.row = static_cast<std::int64_t>(row);
      return evidence;
    }
  return {};
}

// G009 for one part: mode supported, frame, mask and padding as the mode demands.
Evidence check_part(const Limits& limits, const ModeLimits& modes, const ActionChunk& chunk,
                    const ActionPart& action) {
  const PartLimits& part = limits.parts[action.part];
  if (!mode_has_checker(action.mode))
    return broken_rule(code::addressing, mode_name(action.mode), "a mode that has a checker",
                       action.mode);
  if (!modes.supports(action.mode))
    return broken_rule(code::addressing, mode_name(action.mode), "a mode this part declares",
                       action.mode);
  if (is_joint_mode(action.mode)) {
    if (!action.frame_id.empty())
      return broken_rule(code::addressing, "frame_id", "no frame in a joint mode");
    return check_mask(limits, part, chunk, action);
  }
  if (!action.active.empty())
    return broken_rule(code::addressing, "active", "no mask but in a joint mode");
  const FixedVec<Name, max_frames>* frames = frames_of(modes, action.mode);
  if (frames == nullptr && !action.frame_id.empty())
    return broken_rule(code::addressing, "frame_id", "no frame in this mode");
  if (frames != nullptr && !frames->contains(action.frame_id))
    return broken_rule(code::addressing, "frame_id", "a frame declared for this mode");
  const CartesianLimits* norms = norm_block(modes, action.mode);
  return norms == nullptr ? Evidence{} : check_axes(*norms, chunk, action);
}

// G009: each part once. Parts own their joints, so nothing is commanded twice in a tick.
Evidence check_addressing(const Limits& limits, const ClaimLimits& claim,
                          const ActionChunk& chunk) {
  FixedVec<std::uint8_t, max_parts> seen;
  for (const ActionPart& action : chunk.parts) {
    const Name& name = limits.parts[action.part].name;
    if (seen.contains(action.part))
      return of(broken_rule(code::addressing, "parts", "each part at most once"), name);
    (void)seen.push_back(action.part);  // as many places as parts
    Evidence evidence = check_part(limits, claim.modes[action.part], chunk, action);
    if (!evidence.ok()) return at(evidence, evidence.row, name);
  }
  return {};
}

}  // namespace

Evidence check_shape(const Limits& limits, const ClaimLimits& claim, const ActionChunk& chunk) {
  Evidence evidence = check_sizes(limits, claim, chunk);
  if (evidence.ok()) evidence = check_numbers(limits, chunk);
  if (evidence.ok()) evidence = check_addressing(limits, claim, chunk);
  return evidence;
}

}  // namespace fairlead
