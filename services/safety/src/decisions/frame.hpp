// How records stand in a decision log, so that a byte changed, cut off, taken out or moved is
// found.
//
//   file:  "fairlead-decisions-2\n", then frames
//   frame: u8 type, u24 length, u8 check, body, u32 CRC-32 of everything before it in the file
//          but the CRCs
//
// `check` is the XOR of the four bytes before it and 0xA5: a wrong length is not believed.
// Little-endian. A reader that does not know the first line refuses the file.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include "decisions/record.hpp"

namespace fairlead {

inline constexpr std::string_view decisions_magic = "fairlead-decisions-2\n";
inline constexpr std::size_t max_body_bytes = (1U << 24U) - 1;

using FrameHead = std::array<std::uint8_t, 5>;

FrameHead frame_head(RecordType type, std::size_t length);

/// False if the check byte says that the head is damaged.
bool read_head(const FrameHead& head, RecordType& type, std::size_t& length);

}  // namespace fairlead
