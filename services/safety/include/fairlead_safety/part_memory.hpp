// In which mode a part last moved, for as long as that motion may last.
#pragma once

#include <array>
#include <cstdint>

#include "fairlead_safety/limits.hpp"
#include "fairlead_safety/messages.hpp"

namespace fairlead {

/// none: it stood still after a tick in which no row moved it. unknown: it moves, or a row acted
/// that nobody remembers.
struct PartMemory {
  enum class Kind : std::uint8_t { none, known, unknown };
  Kind kind = Kind::none;
  std::uint8_t mode = 0;
  Name frame_id;

  /// A row of this command acted.
  void note(const ActionPart& action) { *this = {Kind::known, action.mode, action.frame_id}; }
  /// A row of this command may still act.
  void add(const ActionPart& action) {
    if (kind == Kind::none) return note(action);
    if (differs(action)) kind = Kind::unknown;
  }
  /// Whether a command is of another mode or frame than what may still move the part.
  [[nodiscard]] bool differs(const ActionPart& action) const {
    if (kind == Kind::none) return false;
    return kind == Kind::unknown || mode != action.mode || !(frame_id == action.frame_id);
  }
};

using PartMemories = std::array<PartMemory, max_parts>;

}  // namespace fairlead
