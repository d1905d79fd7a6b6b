#include "config_modes.hpp"

#include "config_values.hpp"
#include "fairlead_safety/mode_blocks.hpp"

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

void read_joint_mode(Section& section, const PartLimits& part, JointModeLimits& block) {
  const json& steps = section.list("step_limit");
  if (steps.size() != part.joints.size()) {
    refuse(section.path_of("step_limit"),
           std::to_string(part.joints.size()) + " numbers, one per joint of the part", steps);
  }
  for (std::size_t i = 0; i < steps.size(); ++i) {
    if (!steps[i].is_number()) refuse(section.path_of("step_limit", i), "a number", steps[i]);
    block.step_limit[part.joints[i]] = steps[i].get<double>();
  }
}

void read_norms(Section& section, Mode mode, CartesianLimits& block) {
  block.frames = read_frames(section);
  block.linear_limit = section.number("linear_limit");
  block.angular_limit = section.number("angular_limit");
  block.linear_step_limit = section.number("linear_step_limit");
  block.angular_step_limit = section.number("angular_step_limit");
  block.free_axes.fill(true);
  if (mode == Mode::body_twist) block.free_axes = read_axes(section);
}

void read_pose(Section& section, PoseLimits& block) {
  block.frames = read_frames(section);
  block.lower = numbers_in<3>(section, "lower");
  block.upper = numbers_in<3>(section, "upper");
  block.linear_step_limit = section.number("linear_step_limit");
  block.angular_step_limit = section.number("angular_step_limit");
}

// The range of composite_mode is [-1, 1] by definition.
void read_scalar(Section& section, Mode mode, ScalarLimits& block) {
  const bool range_is_listed = mode == Mode::gripper_position;
  block.lower = range_is_listed ? section.number("lower") : -1.0;
  block.upper = range_is_listed ? section.number("upper") : 1.0;
  block.step_limit = section.number("step_limit");
}

void finish(Section& section, auto& block) {
  block.supported = true;
  block.source = source_in(section);
  section.refuse_unknown_keys();
}

void read_mode(Section section, Mode mode, PartLimits& part) {
  const auto number = static_cast<std::uint8_t>(mode);
  if (JointModeLimits* joints = joint_block(part.modes, number)) {
    read_joint_mode(section, part, *joints);
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

}  // namespace

void read_modes(Section section, PartLimits& part) {
  for (const auto& [name, unused] : section.node().items()) {
    const Mode mode = mode_called(name, section.path_of(name));
    read_mode(section.section(name.c_str()), mode, part);
  }
}

}  // namespace fairlead
