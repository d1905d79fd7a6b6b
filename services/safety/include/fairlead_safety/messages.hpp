// The wire messages between robot, runner and gate, field for field in wire order: measured states,
// candidates, what was released, and leases. (Queries: query_messages.hpp.)
//
// Each struct lists its fields once, in `fields()`; the codec walks that list in both directions. A
// top-level message has a `type_id` (element 0 on the wire); element 1 is its version.
#pragma once

#include <array>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <tuple>

#include "fairlead_safety/fixed.hpp"
#include "fairlead_safety/limits.hpp"

namespace fairlead {

/// A block of float64 inside a frame. It does not own the bytes: valid as long as the frame is.
class NumberView {
 public:
  NumberView() = default;
  explicit NumberView(Bytes bytes) : bytes_(bytes) {}

  [[nodiscard]] std::size_t size() const { return bytes_.size() / sizeof(double); }
  [[nodiscard]] Bytes bytes() const { return bytes_; }
  /// Element i; the bytes may be unaligned, hence the copy. Beyond the end the process ends: a
  /// wrong index is a fault of the gate's own.
  double operator[](std::size_t i) const {
    if (i >= size()) std::abort();  // GCOVR_EXCL_LINE: no caller does
    double value;
    std::memcpy(&value, bytes_.data() + i * sizeof(double), sizeof(double));
    return value;
  }
  /// `rows` rows of `width` numbers from row `first` on. The caller has checked the size.
  [[nodiscard]] NumberView rows(std::size_t first, std::size_t rows, std::size_t width) const {
    return NumberView(
        bytes_.subspan(first * width * sizeof(double), rows * width * sizeof(double)));
  }

 private:
  Bytes bytes_;
};

// One list of fields serves reading and writing.
#define FAIRLEAD_FIELDS(...)                      \
  auto fields() { return std::tie(__VA_ARGS__); } \
  auto fields() const { return std::tie(__VA_ARGS__); }

/// Why a part held; 0 means that it executed a row. Of the HAL's list, what the gate says itself.
enum class Hold : std::uint8_t { none = 0, no_row = 2, refused = 6, starting = 9 };

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

struct ActionPart {
  std::uint8_t part = 0;
  std::uint8_t mode = 0;
  Name frame_id;
  NumberView values;  // [horizon x width]
  FixedVec<std::uint8_t, max_joints> active;
  FAIRLEAD_FIELDS(part, mode, frame_id, values, active)
};

using Trace = std::array<std::uint8_t, 24>;

struct ActionChunk {
  static constexpr std::uint8_t type_id = 7;
  Hash robot_hash{};
  std::uint64_t session = 0;
  std::uint64_t epoch = 0;
  std::uint64_t claim_id = 0;
  Name source;
  std::uint64_t seq = 0;
  std::uint64_t goal_id = 0;
  std::uint64_t obs_tick = 0;
  std::uint64_t oldest_tick = 0;
  std::uint64_t start_tick = 0;
  std::uint32_t horizon = 0;
  FixedVec<ActionPart, max_parts> parts;
  Trace trace{};
  FAIRLEAD_FIELDS(robot_hash, session, epoch, claim_id, source, seq, goal_id, obs_tick, oldest_tick,
                  start_tick, horizon, parts, trace)
};

struct SafeChunk {
  static constexpr std::uint8_t type_id = 8;
  std::uint64_t session = 0;
  std::uint64_t epoch = 0;
  std::uint64_t claim_id = 0;
  Name source;
  std::uint64_t verdict_id = 0;
  std::uint64_t judged_tick = 0;
  std::uint64_t first_tick = 0;
  std::uint32_t horizon = 0;
  Acted after;
  FixedVec<ActionPart, max_parts> parts;
  FAIRLEAD_FIELDS(session, epoch, claim_id, source, verdict_id, judged_tick, first_tick, horizon,
                  after, parts)
};

enum class Decision : std::uint8_t { undecided = 0, row = 1, hold = 2 };

struct Grant {
  Name source;
  std::uint64_t claim_id = 0;
  std::uint64_t until_tick = 0;
  std::uint8_t decision = 0;
  std::uint64_t verdict_id = 0;
  FAIRLEAD_FIELDS(source, claim_id, until_tick, decision, verdict_id)
  friend bool operator==(const Grant&, const Grant&) = default;
};

enum class GateState : std::uint8_t { boot = 0, disarmed = 1, armed = 2, stopped = 3, latched = 4 };

struct Lease {
  static constexpr std::uint8_t type_id = 9;
  std::uint64_t session = 0;
  std::uint64_t epoch = 0;
  std::uint64_t lease_seq = 0;
  Hash config_hash{};
  std::uint8_t state = 0;
  std::uint64_t state_tick = 0;
  FixedVec<Grant, max_claims> grants;
  FixedVec<std::uint64_t, max_stops> stop_ids;
  FAIRLEAD_FIELDS(session, epoch, lease_seq, config_hash, state, state_tick, grants, stop_ids)
  friend bool operator==(const Lease&, const Lease&) = default;
};

enum class Outcome : std::uint8_t { released = 0, truncated = 1, refused = 2 };

struct Verdict {
  static constexpr std::uint8_t type_id = 10;
  static constexpr std::size_t optional_fields = 1;
  std::uint64_t verdict_id = 0;
  std::uint64_t session = 0;
  std::uint64_t epoch = 0;
  std::uint64_t claim_id = 0;
  Name source;
  std::uint64_t seq = 0;
  std::uint8_t outcome = 0;
  std::uint32_t code = 0;
  std::int64_t row = -1;
  Name part;
  Text axis;
  double value = 0.0;
  double limit = 0.0;
  double margin = 0.0;
  Text limit_source;
  std::uint64_t released_first = 0;
  std::uint64_t released_last = 0;
  Hash config_hash{};
  std::uint64_t latency_ns = 0;
  Name unit;  // of value, limit and margin; empty: a rule, or by an older gate
  FAIRLEAD_FIELDS(verdict_id, session, epoch, claim_id, source, seq, outcome, code, row, part, axis,
                  value, limit, margin, limit_source, released_first, released_last, config_hash,
                  latency_ns, unit)
};

struct StopLevel {
  static constexpr std::uint8_t type_id = 12;
  std::uint64_t stop_id = 0;
  Text by;
  Text reason;
  FAIRLEAD_FIELDS(stop_id, by, reason)
};

struct Heartbeat {
  static constexpr std::uint8_t type_id = 13;
  std::uint64_t claim_id = 0;
  FAIRLEAD_FIELDS(claim_id)
};

}  // namespace fairlead
