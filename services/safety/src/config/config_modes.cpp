#include "config/config_modes.hpp"

#include <limits>

#include "config/config_values.hpp"
#include "fairlead_safety/limits.hpp"

namespace fairlead {
namespace {

using nlohmann::json;

using Frames = FixedVec<Name, max_frames>;

Frames read_frames(Section& section) {
  Frames names;
  const json& frames = section.list("frames");
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const std::string path = section.path_of("frames", i);
    if (!frames[i].is_string() || frames[i].get_ref<const std::string&>().size() > Name::capacity) {
      refuse(path, "a frame name", frames[i]);
    }
    append(names, Name(frames[i].get_ref<const std::string&>()), path);
  }
  return names;
}

std::array<bool, 6> read_axes(Section& section) {
  std::array<bool, 6> axes{};
  const json& list = section.list("free_axes");
  for (std::size_t i = 0; i < list.size(); ++i) {
    const auto axis = list[i].is_number_unsigned() ? list[i].get<std::size_t>() : axes.size();
    if (axis >= axes.size() || axes[axis]) {
      refuse(section.path_of("free_axes", i), "an axis from 0 to 5, each once", list[i]);
    }
    axes[axis] = true;
  }
  return axes;
}

// The file lists one number per joint of the part; `numbers` has one per joint of the robot.
void read_per_joint(Section& section, const char* key, const PartLimits& part,
                    std::array<double, max_joints>& numbers) {
  const json& list = section.list(key);
  if (list.size() != part.joints.size()) {
    refuse(section.path_of(key),
           std::to_string(part.joints.size()) + " numbers, one per joint of the part", list);
  }
  for (std::size_t i = 0; i < list.size(); ++i) {
    if (!list[i].is_number()) refuse(section.path_of(key, i), "a number", list[i]);
    numbers[part.joints[i]] = list[i].get<double>();
  }
}

Gain read_gain(Section& section) {
  const auto [lower, upper] = numbers_in<2>(section, "gain");
  return {lower, upper};
}

void read_joint_mode(Section& section, Mode mode, const PartLimits& part, JointModeLimits& block) {
  read_per_joint(section, "step_limit", part, block.step_limit);
  if (mode == Mode::joint_velocity) block.gain = read_gain(section);
  read_per_joint(section, "tracking", part, block.tracking);
}

void read_norms(Section& section, Mode mode, CartesianLimits& block) {
  block.frames = read_frames(section);
  block.linear_limit = section.number("linear_limit");
  block.angular_limit = section.number("angular_limit");
  block.linear_step_limit = section.number("linear_step_limit");
  block.angular_step_limit = section.number("angular_step_limit");
  block.free_axes.fill(true);
  if (mode == Mode::body_twist) block.free_axes = read_axes(section);
  block.gain = read_gain(section);
  block.linear_tracking = section.number("linear_tracking");
  block.angular_tracking = section.number("angular_tracking");
}

void read_pose(Section& section, PoseLimits& block) {
  block.frames = read_frames(section);
  block.lower = numbers_in<3>(section, "lower");
  block.upper = numbers_in<3>(section, "upper");
  block.linear_step_limit = section.number("linear_step_limit");
  block.angular_step_limit = section.number("angular_step_limit");
  block.linear_tracking = section.number("linear_tracking");
  block.angular_tracking = section.number("angular_tracking");
}

// Null declares that losing an object is no stop.
double read_slip(Section& section) {
  constexpr double any_slip = std::numeric_limits<double>::infinity();
  return section.any("slip_limit").is_null() ? any_slip : section.number("slip_limit");
}

bool read_switching(Section& section) {
  const std::string where = section.text("switching", 64);
  if (where == "anywhere" || where == "at_standstill") return where == "anywhere";
  refuse(section.path_of("switching"), "anywhere or at_standstill", where);
}

// The range of composite_mode is [-1, 1] by definition.
void read_scalar(Section& section, Mode mode, ScalarLimits& block) {
  const bool grips = mode == Mode::gripper_position;
  block.lower = grips ? section.number("lower") : -1.0;
  block.upper = grips ? section.number("upper") : 1.0;
  block.step_limit = section.number("step_limit");
  if (grips) block.slip_limit = read_slip(section);
  if (!grips) block.switches_anywhere = read_switching(section);
}

void finish(Section& section, auto& block) {
  block.supported = true;
  block.source = source_in(section);
  section.refuse_unknown_keys();
}

void read_mode(Section section, Mode mode, PartLimits& part) {
  const auto number = static_cast<std::uint8_t>(mode);
  if (JointModeLimits* joints = joint_block(part.modes, number)) {
    read_joint_mode(section, mode, part, *joints);
    finish(section, *joints);
  } else if (CartesianLimits* norms = norm_block(part.modes, number)) {
    read_norms(section, mode, *norms);
    finish(section, *norms);
  } else if (ScalarLimits* scalar = scalar_block(part.modes, number)) {
    read_scalar(section, mode, *scalar);
    finish(section, *scalar);
  } else if (mode == Mode::cartesian_pose) {
    read_pose(section, part.modes.cartesian_pose);
    finish(section, part.modes.cartesian_pose);
  } else {
    finish(section, part.modes.gripper_binary);
  }
}

std::string modes_with_a_checker() {
  std::string list;
  for (std::uint8_t mode = 0; mode < mode_count; ++mode) {
    if (mode_has_checker(mode)) list += (list.empty() ? "" : ", ") + std::string(mode_name(mode));
  }
  return list;
}

Mode mode_called(const std::string& name, const std::string& path) {
  for (std::uint8_t mode = 0; mode < mode_count; ++mode) {
    if (mode_has_checker(mode) && mode_name(mode) == name) return static_cast<Mode>(mode);
  }
  throw ConfigRefused(path + ": no checker for this mode (valid: " + modes_with_a_checker() + ")");
}

std::string modes_of(const PartLimits& part) {
  std::string list;
  for (std::uint8_t mode = 0; mode < mode_count; ++mode) {
    if (part.modes.supports(mode))
      list += (list.empty() ? "" : ", ") + std::string(mode_name(mode));
  }
  return list;
}

std::uint8_t mode_of(const json& name, const PartLimits& part, const std::string& path) {
  for (std::uint8_t mode = 0; mode < mode_count; ++mode)
    if (part.modes.supports(mode) && json(mode_name(mode)) == name) return mode;
  refuse(path, "a mode of the part (valid: " + modes_of(part) + ")", name);
}

}  // namespace

void read_transitions(Section& part, PartLimits& limits) {
  const json& pairs = part.list("transitions");
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const std::string path = part.path_of("transitions", i);
    if (!pairs[i].is_array() || pairs[i].size() != 2) refuse(path, "two modes: from, to", pairs[i]);
    const std::uint8_t from = mode_of(pairs[i][0], limits, path + "[0]");
    const std::uint8_t to = mode_of(pairs[i][1], limits, path + "[1]");
    const auto bit = static_cast<std::uint16_t>(1U << to);
    if (from == to) refuse(path, "two modes that differ", pairs[i]);
    if ((limits.followers[from] & bit) != 0) refuse(path, "each pair once", pairs[i]);
    limits.followers[from] = static_cast<std::uint16_t>(limits.followers[from] | bit);
  }
}

void read_modes(Section section, PartLimits& part) {
  for (const auto& [name, unused] : section.node().items()) {
    const Mode mode = mode_called(name, section.path_of(name));
    read_mode(section.section(name.c_str()), mode, part);
  }
}

}  // namespace fairlead
