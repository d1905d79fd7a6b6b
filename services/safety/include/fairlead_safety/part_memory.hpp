// In which mode a part last moved, for as long as that motion may last, and what acted last.
#pragma once

#include <array>
#include <cstdint>

#include "fairlead_safety/limits.hpp"
#include "fairlead_safety/messages.hpp"

namespace fairlead {

/// Which way a composite row switches: below 0 or not. unknown: a row that nobody remembers.
enum class Switch : std::uint8_t { none, negative, positive, unknown };

inline Switch switch_of(double value) { return value < 0.0 ? Switch::negative : Switch::positive; }

/// none: it stood still after a tick in which no row moved it. unknown: it moves, or a row acted
/// that nobody remembers.
struct PartMemory {
  enum class Kind : std::uint8_t { none, known, unknown };
  Kind kind = Kind::none;
  std::uint8_t mode = 0;
  Name frame_id;
  // The last row that acted since arming, also after standstill: bit m is set if it may have been
  // of mode m, none if no row has acted.
  std::uint16_t acted_modes = 0;
  Switch composite = Switch::none;  // of that row, if it was one of composite_mode

  /// A row of this command may move the part.
  void note(const ActionPart& action) {
    kind = Kind::known;
    mode = action.mode;
    frame_id = action.frame_id;
  }
  /// A row of this command may still act.
  void add(const ActionPart& action) {
    if (kind == Kind::none) return note(action);
    if (differs(action)) kind = Kind::unknown;
  }
  /// The part stood still after a tick in which no row moved it.
  void rest() { kind = Kind::none; }
  /// A row acted of a claim that has ended: `add` has noted its mode, unless there were two.
  void note_forgotten(std::uint16_t all_modes) {
    if (kind == Kind::none) kind = Kind::unknown;
    acted_modes = kind == Kind::known ? mode_bit(mode) : all_modes;
    composite = Switch::unknown;
  }
  /// Whether a command is of another mode or frame than what may still move the part.
  [[nodiscard]] bool differs(const ActionPart& action) const {
    if (kind == Kind::none) return false;
    return kind == Kind::unknown || mode != action.mode || !(frame_id == action.frame_id);
  }
  static std::uint16_t mode_bit(std::uint8_t mode) {
    return static_cast<std::uint16_t>(1U << mode);
  }
};

using PartMemories = std::array<PartMemory, max_parts>;

}  // namespace fairlead
