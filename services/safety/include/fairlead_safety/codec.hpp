// Bytes to messages and back: msgpack arrays, fields by position.
//
// Reading is a bounded cursor over the frame: no allocation, no recursion that data could
// drive (nesting is fixed by the message's type), exact arities, no trailing bytes. Writing
// goes into a buffer of the caller and produces the same bytes as Python's msgspec.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "fairlead_safety/fixed.hpp"

namespace fairlead {

enum class FrameFault : std::uint8_t {
  none,
  oversized,   // more than 64 KiB
  cut_short,   // the frame ends inside a field
  wrong_type,  // a field is not of the msgpack type its place demands, or out of its range
  arity,       // an array has another number of fields
  message,     // element 0: another message type
  version,     // element 1: another version
  capacity,    // a list or an identifier is longer than the gate supports
  text,        // not UTF-8, or a control character in a name
  trailing,    // bytes after the message
};

/// For verdicts and logs, for example "trailing bytes".
std::string_view fault_name(FrameFault fault);

/// Decode one frame into `message`. On a fault `message` is unspecified and must not be used, and
/// `at` is the byte at which it was found. NumberViews in the message point into `frame`.
template <class Message>
FrameFault decode(Bytes frame, Message& message, std::size_t* at = nullptr);

/// Encode into `buffer`; returns the number of bytes written, 0 if they do not fit.
template <class Message>
std::size_t encode(const Message& message, std::span<std::uint8_t> buffer);

// All are instantiated in codec.cpp for every message.

struct ChunkHead {
  std::uint64_t session = 0;
  std::uint64_t epoch = 0;
  std::uint64_t claim_id = 0;
};

/// False if the frame does not begin as an ActionChunk does.
bool read_chunk_head(Bytes frame, ChunkHead& head);

}  // namespace fairlead
