#include "config/config_shape.hpp"

#include "config/config_values.hpp"

namespace fairlead {
namespace {

using nlohmann::json;

using Corners = FixedVec<Corner, max_corners>;

Capsule read_capsule(Section section, const Kinematics& kinematics) {
  Capsule capsule;
  const Name link = name_in(section, "link");
  capsule.link = kinematics.find(link);
  if (capsule.link == no_link)
    refuse(section.path_of("link"), "the name of a link of `kinematics`", std::string(link.view()));
  capsule.a = numbers_in<3>(section, "a");
  capsule.b = numbers_in<3>(section, "b");
  capsule.radius = section.number("radius");
  section.refuse_unknown_keys();
  return capsule;
}

CapsulePair read_pair(const json& pair, const std::string& path) {
  const auto is_index = [](const json& entry) {
    return entry.is_number_unsigned() && entry.get<std::uint64_t>() < max_capsules;
  };
  if (!pair.is_array() || pair.size() != 2 || !is_index(pair[0]) || !is_index(pair[1]))
    refuse(path, "two indices of `capsules`", pair);
  return {pair[0].get<std::uint8_t>(), pair[1].get<std::uint8_t>()};
}

// "keep_in" or "keep_out"
bool read_kind(Section& section) {
  const std::string kind = section.text("kind", 64);
  if (kind == "keep_in" || kind == "keep_out") return kind == "keep_out";
  refuse(section.path_of("kind"), "keep_in or keep_out", kind);
}

Volume read_volume(Section section) {
  Volume volume;
  volume.name = name_in(section, "name");
  volume.keep_out = read_kind(section);
  volume.lower = numbers_in<3>(section, "lower");
  volume.upper = numbers_in<3>(section, "upper");
  section.refuse_unknown_keys();
  return volume;
}

Corners read_corners(Section& section, const char* key) {
  Corners corners;
  const json& list = section.list(key);
  for (std::size_t i = 0; i < list.size(); ++i) {
    const std::string path = section.path_of(key, i);
    if (!list[i].is_array() || list[i].size() != 2 || !list[i][0].is_number() ||
        !list[i][1].is_number())
      refuse(path, "two numbers", list[i]);
    append(corners, Corner{list[i][0].get<double>(), list[i][1].get<double>()}, path);
  }
  return corners;
}

Zone read_zone(Section section) {
  Zone zone;
  zone.name = name_in(section, "name");
  zone.keep_out = read_kind(section);
  zone.corners = read_corners(section, "corners");
  section.refuse_unknown_keys();
  return zone;
}

// "odom" or "against_yaw"
bool read_command_frame(Section& section) {
  const std::string frame = section.text("command_frame", 64);
  if (frame == "odom" || frame == "against_yaw") return frame == "against_yaw";
  refuse(section.path_of("command_frame"), "odom or against_yaw", frame);
}

void read_base_joints(Section& section, const Limits& limits, BaseLimits& base) {
  const json& names = section.list("joints");
  if (names.size() != base.joints.size())
    refuse(section.path_of("joints"), "the names of 3 joints: x, y and yaw", names);
  for (std::size_t i = 0; i < names.size(); ++i) {
    for (std::size_t j = 0; j < limits.joints.size(); ++j)
      if (json(limits.joints[j].name.view()) == names[i]) base.joints[i] = j;
    if (base.joints[i] == max_joints)
      refuse(section.path_of("joints", i), "the name of one of `joints`", names[i]);
  }
}

}  // namespace

CollisionLimits read_collision(Section section, const Kinematics& kinematics) {
  CollisionLimits shape;
  const json& capsules = section.list("capsules");
  for (std::size_t i = 0; i < capsules.size(); ++i) {
    const std::string path = section.path_of("capsules", i);
    append(shape.capsules, read_capsule(Section(capsules[i], path), kinematics), path);
  }
  const json& pairs = section.list("pairs");
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const std::string path = section.path_of("pairs", i);
    append(shape.pairs, read_pair(pairs[i], path), path);
  }
  shape.clearance = section.number("clearance");
  shape.source = source_in(section);
  section.refuse_unknown_keys();
  return shape;
}

WorkspaceLimits read_workspace(Section section) {
  WorkspaceLimits workspace;
  const json& volumes = section.list("volumes");
  for (std::size_t i = 0; i < volumes.size(); ++i) {
    const std::string path = section.path_of("volumes", i);
    append(workspace.volumes, read_volume(Section(volumes[i], path)), path);
  }
  workspace.source = source_in(section);
  section.refuse_unknown_keys();
  return workspace;
}

BaseLimits read_base(Section& file, const Limits& limits) {
  BaseLimits base;
  if (file.any("base").is_null()) return base;
  Section section = file.section("base");
  base.present = true;
  read_base_joints(section, limits, base);
  base.against_yaw = read_command_frame(section);
  base.yaw_axis = numbers_in<2>(section, "yaw_axis");
  base.footprint = read_corners(section, "footprint");
  base.reaction_s = section.number("reaction_s");
  base.tool_drift = section.number("tool_drift");
  base.clearance_drift = section.number("clearance_drift");
  const json& zones = section.list("zones");
  for (std::size_t i = 0; i < zones.size(); ++i) {
    const std::string path = section.path_of("zones", i);
    append(base.zones, read_zone(Section(zones[i], path)), path);
  }
  base.source = source_in(section);
  section.refuse_unknown_keys();
  return base;
}

}  // namespace fairlead
