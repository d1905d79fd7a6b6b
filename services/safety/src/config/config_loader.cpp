#include "config/config_loader.hpp"

#include <algorithm>
#include <fstream>
#include <iterator>
#include <limits>
#include <string>

#include "config/config_modes.hpp"
#include "config/config_shape.hpp"
#include "config/config_tree.hpp"
#include "config/config_values.hpp"
#include "config/sha256.hpp"
#include "fairlead_safety/limits.hpp"

namespace fairlead {
namespace {

using nlohmann::json;

constexpr std::uint64_t kMaxU32 = std::numeric_limits<std::uint32_t>::max();

Hash hash_in(Section& section, const char* key) {
  const std::string hex = section.text(key, 64);
  Hash hash{};
  if (hex.size() != 64 || hex.find_first_not_of("0123456789abcdef") != std::string::npos) {
    refuse(section.path_of(key), "64 lower-case hexadecimal digits", hex);
  }
  for (std::size_t i = 0; i < hash.size(); ++i) {
    hash[i] = static_cast<std::uint8_t>(std::stoul(hex.substr(2 * i, 2), nullptr, 16));
  }
  return hash;
}

Bounds read_bounds(Section section) {
  const Bounds bounds{section.number("lower"), section.number("upper"),
                      section.number("tolerance")};
  section.refuse_unknown_keys();
  return bounds;
}

JointKind read_kind(Section& section) {
  const std::string kind = section.text("kind", 64);
  if (kind == "revolute") return JointKind::revolute;
  if (kind == "prismatic") return JointKind::prismatic;
  if (kind == "continuous") return JointKind::continuous;
  refuse(section.path_of("kind"), "revolute, prismatic or continuous", kind);
}

// Either bounds, or zones: the declaration that the joint is bounded in the frame `odom`; null, of
// a continuous joint, is the declaration that it turns without end.
void read_extent(Section& section, JointLimits& joint) {
  const bool continuous = joint.kind == JointKind::continuous;
  if (continuous && section.has("bounds") && section.any("bounds").is_null()) {
    joint.bounded = false;
    return;
  }
  joint.bounded = !section.has("zones");
  if (joint.bounded) {
    joint.bounds = read_bounds(section.section("bounds"));
    return;
  }
  Section zones = section.section("zones");
  if (zones.text("frame", Name::capacity) != "odom") {
    refuse(zones.path_of("frame"), "\"odom\"", zones.node().at("frame"));
  }
  zones.refuse_unknown_keys();
}

std::size_t index_of_part(const json& parts, const std::string& name, const std::string& path) {
  for (std::size_t i = 0; i < parts.size(); ++i) {
    if (parts[i].is_object() && parts[i].value("name", json()) == json(name)) return i;
  }
  throw ConfigRefused(path + ": no part is called '" + name + "'");
}

// Null for a joint that nothing tells how fast: a gripper's. `check_limits` sees to it.
double read_speed(Section& section, const char* key) {
  return section.any(key).is_null() ? unset : section.number(key);
}

JointLimits read_joint(Section section, const json& parts) {
  JointLimits joint;
  joint.name = name_in(section, "name");
  joint.part = index_of_part(parts, section.text("part", Name::capacity), section.path_of("part"));
  joint.kind = read_kind(section);
  read_extent(section, joint);
  joint.velocity_limit = read_speed(section, "velocity_limit");
  joint.acceleration_limit = read_speed(section, "acceleration_limit");
  joint.effort_limit = section.number("effort_limit");
  joint.jump_limit = section.number("jump_limit");
  joint.standstill_velocity = section.number("standstill_velocity");
  joint.contact_limit = section.number("contact_limit");
  joint.encoder_step = section.number("encoder_step");
  joint.dead_band = section.number("dead_band");
  joint.stop_lag = section.number("stop_lag");
  joint.source = source_in(section);
  section.refuse_unknown_keys();
  return joint;
}

PassiveLimits read_passive(Section section) {
  PassiveLimits joint;
  joint.name = name_in(section, "name");
  joint.bounds = read_bounds(section.section("bounds"));
  joint.jump_limit = section.number("jump_limit");
  joint.standstill_velocity = section.number("standstill_velocity");
  joint.source = source_in(section);
  section.refuse_unknown_keys();
  return joint;
}

void read_part_joints(Section& section, const Limits& limits, PartLimits& part) {
  const json& names = section.list("joints");
  for (std::size_t i = 0; i < names.size(); ++i) {
    std::size_t joint = 0;
    while (joint < limits.joints.size() && json(limits.joints[joint].name.view()) != names[i])
      ++joint;
    if (joint == limits.joints.size()) {
      refuse(section.path_of("joints", i), "the name of one of `joints`", names[i]);
    }
    append(part.joints, joint, section.path_of("joints", i));
  }
}

// Only modes that move the tool are judged by its Jacobian.
double read_singularity(Section& section, const PartLimits& part) {
  if (moves_tool(part.modes)) return section.number("singularity_limit");
  const json& none = section.any("singularity_limit");
  if (!none.is_null())
    refuse(section.path_of("singularity_limit"), "null for a part without cartesian modes", none);
  return unset;
}

PartLimits read_part(Section section, const Limits& limits) {
  PartLimits part;
  part.name = name_in(section, "name");
  read_part_joints(section, limits, part);
  part.tool = read_tool(section, limits.kinematics);
  read_modes(section.section("modes"), part);
  part.singularity_limit = read_singularity(section, part);
  read_transitions(section, part);
  part.source = source_in(section);
  section.refuse_unknown_keys();
  return part;
}

ProtocolLimits read_protocol(Section section) {
  const auto count = [&section](const char* key) {
    return static_cast<std::uint32_t>(section.integer(key, 1, kMaxU32));
  };
  ProtocolLimits protocol;
  protocol.horizon_max = static_cast<std::uint32_t>(section.integer("horizon_max", 1, max_rows));
  protocol.age_max_ticks = count("age_max_ticks");
  protocol.chunk_rate_max_hz = section.number("chunk_rate_max_hz");
  protocol.seq_jump_max = section.integer("seq_jump_max", 1, kMaxU32);
  protocol.state_timeout_ms = count("state_timeout_ms");
  protocol.heartbeat_timeout_realtime_ms = count("heartbeat_timeout_realtime_ms");
  protocol.heartbeat_timeout_lockstep_ms = count("heartbeat_timeout_lockstep_ms");
  protocol.lease_interval_ms = count("lease_interval_ms");
  protocol.idle_disarm_s = count("idle_disarm_s");
  protocol.stops_to_latch = count("stops_to_latch");
  protocol.stop_window_s = count("stop_window_s");
  protocol.bad_frames_limit = count("bad_frames_limit");
  protocol.bad_frames_window_ticks = count("bad_frames_window_ticks");
  protocol.stuck_ticks = count("stuck_ticks");
  protocol.stop_ramp_ms = count("stop_ramp_ms");
  protocol.step_deadline_us = count("step_deadline_us");
  if (section.has("second_person_s")) protocol.second_person_s = count("second_person_s");
  section.refuse_unknown_keys();
  return protocol;
}

void read_joints(Section& file, Limits& limits) {
  const json& joints = file.list("joints");
  const json& passive = file.list("passive_joints");
  const json& parts = file.list("parts");
  for (std::size_t i = 0; i < joints.size(); ++i) {
    const std::string path = file.path_of("joints", i);
    append(limits.joints, read_joint(Section(joints[i], path), parts), path);
  }
  for (std::size_t i = 0; i < passive.size(); ++i) {
    const std::string path = file.path_of("passive_joints", i);
    append(limits.passive_joints, read_passive(Section(passive[i], path)), path);
  }
}

// Zones are the base's: no other joint can be bounded by them.
void check_zoned(const json& joints, const Limits& limits) {
  const auto& own = limits.base.joints;
  for (std::size_t i = 0; i < joints.size(); ++i) {
    const bool is_base = limits.base.present && std::ranges::find(own, i) != own.end();
    if (joints[i].contains("zones") && !is_base)
      refuse("joints[" + std::to_string(i) + "].zones", "a joint of base.joints",
             joints[i].at("name"));
  }
}

void read_parts(Section& file, Limits& limits) {
  const json& parts = file.list("parts");
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const std::string path = file.path_of("parts", i);
    append(limits.parts, read_part(Section(parts[i], path), limits), path);
  }
}

}  // namespace

std::unique_ptr<Limits> parse_limits(std::string_view text) {
  const json document = parse_strictly(text);
  Section file(document, "");
  if (file.text("format", 64) != "fairlead-gate-1") {
    refuse("format", "\"fairlead-gate-1\"", document.at("format"));
  }
  auto limits = std::make_unique<Limits>();
  limits->robot = name_in(file, "robot");
  limits->profile = name_in(file, "profile");
  limits->robot_hash = hash_in(file, "robot_hash");
  limits->period_ns = file.integer("period_ns", 1, 10'000'000'000);
  limits->lockstep_allowed = file.boolean("lockstep_allowed");
  read_joints(file, *limits);
  limits->kinematics = read_tree(file.section("kinematics"), *limits);
  read_parts(file, *limits);
  limits->collision = read_collision(file.section("collision"), limits->kinematics);
  limits->workspace = read_workspace(file.section("workspace"));
  limits->base = read_base(file, *limits);
  check_zoned(file.list("joints"), *limits);
  limits->protocol = read_protocol(file.section("protocol"));
  // What the file was made of is `check_origin`'s: a recorded file has no robot beside it.
  for (const char* key : {"compiled_from", "content_sha256"})
    if (file.has(key)) file.any(key);
  file.refuse_unknown_keys();
  limits->config_hash =
      sha256(Bytes(reinterpret_cast<const std::uint8_t*>(text.data()), text.size()));
  if (const Text fault = check_limits(*limits); !fault.empty()) {
    throw ConfigRefused(std::string(fault.view()));
  }
  return limits;
}

std::unique_ptr<Limits> load_limits(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  if (!stream || std::filesystem::is_directory(file)) {
    throw ConfigRefused("configuration " + file.string() +
                        ": cannot be read; make it with: fairlead robot compile");
  }
  const std::string text{std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
  try {
    return parse_limits(text);
  } catch (const ConfigRefused& refusal) {
    throw ConfigRefused("configuration " + file.string() + ": " + refusal.what());
  }
}

}  // namespace fairlead
