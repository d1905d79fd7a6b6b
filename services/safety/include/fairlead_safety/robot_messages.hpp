// What the robot tells the gate: its measured state, and who it is.
#pragma once

#include <cstdint>

#include "fairlead_safety/limits.hpp"
#include "fairlead_safety/wire_fields.hpp"

namespace fairlead {

/// Why a part held; 0 means that it executed a row. Mirrors the HAL's list.
enum class Hold : std::uint8_t {
  none = 0,
  no_claim,
  no_row,
  not_granted,
  lease_stale,
  stopped,
  refused,
  resetting,
  superseded,
  starting
};

/// What one part did in a tick: row `row` of SafeChunk `verdict_id`, or a hold.
struct Acted {
  std::uint8_t hold = static_cast<std::uint8_t>(Hold::starting);
  std::uint64_t verdict_id = 0;
  std::uint32_t row = 0;
  FAIRLEAD_FIELDS(hold, verdict_id, row)
  friend bool operator==(const Acted&, const Acted&) = default;
};

/// Two holds match whatever their reasons; rows match if verdict and row do.
inline bool same_act(const Acted& a, const Acted& b) {
  if (a.hold != 0 || b.hold != 0) return a.hold != 0 && b.hold != 0;
  return a.verdict_id == b.verdict_id && a.row == b.row;
}

struct JointState {
  static constexpr std::uint8_t type_id = 1;
  std::uint64_t session = 0;
  std::uint64_t tick = 0;
  std::uint64_t episode_tick = 0;
  std::uint64_t stamp_ns = 0;
  NumberView positions;
  NumberView velocities;
  NumberView efforts;
  FixedVec<Acted, max_parts> acted;
  Hash robot_hash{};
  FAIRLEAD_FIELDS(session, tick, episode_tick, stamp_ns, positions, velocities, efforts, acted,
                  robot_hash)
};

struct ModeRange {
  std::uint8_t mode = 0;
  NumberView lower;
  NumberView upper;
  FAIRLEAD_FIELDS(mode, lower, upper)
};

struct HalPart {
  Name name;
  Name simulator_part;
  FixedVec<Name, max_joints> joints;
  FixedVec<ModeRange, mode_count> ranges;
  FAIRLEAD_FIELDS(name, simulator_part, joints, ranges)
};

struct HalCamera {
  Name name;
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  std::uint32_t period_ticks = 0;
  FAIRLEAD_FIELDS(name, width, height, period_ticks)
};

struct HalStatus {
  static constexpr std::uint8_t type_id = 5;
  std::uint64_t session = 0;
  Name robot;
  Hash robot_hash{};
  Name pacing;  // "realtime" or "lockstep"
  std::uint64_t period_ns = 0;
  std::uint64_t tick = 0;
  std::uint64_t episode_tick = 0;
  Name state;
  Text detail;
  FixedVec<Name, max_joints> joints;
  FixedVec<Name, max_passive> passive_joints;
  FixedVec<HalPart, max_parts> parts;
  FixedVec<Name, max_joints> simulator_order;
  FixedVec<HalCamera, 32> cameras;
  bool has_task = false;
  std::uint64_t overruns = 0;
  FAIRLEAD_FIELDS(session, robot, robot_hash, pacing, period_ns, tick, episode_tick, state, detail,
                  joints, passive_joints, parts, simulator_order, cameras, has_task, overruns)
};

}  // namespace fairlead
