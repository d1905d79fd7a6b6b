// The decision itself: pure functions of (limits, measured state, chunk, what acted before).
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include "core/release/part_memory.hpp"
#include "fairlead_safety/limits.hpp"
#include "fairlead_safety/messages.hpp"

namespace fairlead {

/// Why something was not released: the stable code, the place, and the numbers.
/// Its texts point into the limits or at literals: it is used up within the step that made it.
struct Evidence {
  std::uint32_t code = 0;  // 1..50 for G001..G050, 0: nothing to report
  std::int64_t row = -1;   // row of the chunk, -1 if none
  std::string_view part;
  std::string_view axis;
  double value = 0.0;
  double limit = 0.0;
  double margin = 0.0;    // limit minus value, at a lower limit value minus limit: negative outside
  std::string_view unit;  // of value and limit, where a stop tells them
  std::string_view key;   // in robot.yaml's safety, of the limit, where a stop tells it
  std::string_view limit_source;
  bool raises_stop = false;

  [[nodiscard]] bool ok() const { return code == 0; }
};

/// The newest measured state, copied out of its frame. SI, commanded joints then passive ones.
struct MeasuredState {
  std::uint64_t tick = 0;
  std::size_t count = 0;
  std::array<double, max_measured> positions{};
  std::array<double, max_measured> velocities{};
  std::array<double, max_measured> efforts{};
  // What the positions say of the speed since the state before, beyond the noise of the encoder; 0
  // in the first state of an episode.
  std::array<double, max_measured> travel_speeds{};
  FixedVec<Acted, max_parts> acted;  // what each part did in tick - 1
};

/// The row that acts in the tick before the chunk's first live row; empty after a hold.
struct RowBefore {
  const ActionChunk* chunk = nullptr;  // nullptr: the parts hold in that tick
  std::size_t row = 0;
  bool measured = true;  // the newest state was measured after it acted (lockstep)
  const PartMemories* memories = nullptr;  // by part; nullptr: nothing moved before
};

struct Judgement {
  Outcome outcome = Outcome::refused;
  std::size_t first_row = 0;  // first live row of the chunk
  std::size_t row_count = 0;  // rows released, 0 if refused
  std::size_t looks = 0;      // configurations that G031, G032 and G034 looked at
  Evidence evidence;          // why the rest was not
};

/// What one claim may do: its parts and its own, never looser, limits.
struct ClaimLimits {
  FixedVec<std::size_t, max_parts> parts;  // indices into Limits::parts
  std::array<ModeLimits, max_parts> modes;
  std::uint32_t horizon_max = 0;
  std::uint32_t age_max_ticks = 0;
};

/// G007, G008, G009: does the chunk have the shape it says, finite numbers, and only commands
/// that its parts know? Judges every row, past ones too.
Evidence check_shape(const Limits& limits, const ClaimLimits& claim, const ActionChunk& chunk);

/// G011 of a released row that is about to act: may it still, in this state?
Evidence check_running(const Limits& limits, const ClaimLimits& claim, const MeasuredState& state,
                       const ActionChunk& chunk, std::size_t row);

/// G011: every joint there and finite. `state` is the decoded message.
Evidence check_state(const Limits& limits, const JointState& state);

/// G013: no joint moved further between two states than it can in the ticks between them.
Evidence check_jump(const Limits& limits, const MeasuredState& before, const MeasuredState& now);

/// G042: no commanded joint is measured to press harder than its contact limit.
Evidence check_contact(const Limits& limits, const MeasuredState& state);

}  // namespace fairlead
