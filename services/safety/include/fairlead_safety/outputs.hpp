// What one step wants done, in the order in which it must be done.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "fairlead_safety/codec.hpp"
#include "fairlead_safety/fixed.hpp"
#include "fairlead_safety/limits.hpp"

namespace fairlead {

enum class OutputKind : std::uint8_t {
  safe_chunk = 1,         // publish on action/safe/<source>
  verdict = 2,            // publish on safety/verdict/<source>
  lease = 3,              // publish on safety/lease
  status = 4,             // publish on safety/status
  reply = 5,              // answer the query of this step
  refusal = 6,            // answer the query of this step with this error
  persist_latch = 7,      // write the payload to disk (writer thread); it comes back in BootInfo
  clear_latch = 8,        // forget the persisted latch
  write_clean_mark = 9,   // the gate is disarmed: exiting from here on is clean
  clear_clean_mark = 10,  // about to leave disarmed: exiting from here on is not clean
  log = 11,               // payload is UTF-8 text, one line
};

struct Output {
  OutputKind kind = OutputKind::log;
  Name source;  // safe_chunk, verdict: last chunk of the key
  std::size_t offset = 0;
  std::size_t size = 0;
};

/// Outputs of one step with their bytes. About 1 MiB: the shell owns one, not on its stack.
class Outputs {
 public:
  void clear() {
    items_.clear();
    used_ = 0;
    overflowed_ = false;
  }
  [[nodiscard]] const FixedVec<Output, 96>& items() const { return items_; }
  [[nodiscard]] Bytes payload(const Output& output) const {
    return Bytes(arena_).subspan(output.offset, output.size);
  }
  /// True if something did not fit. What is missing is never permission: the HAL holds without it.
  [[nodiscard]] bool overflowed() const { return overflowed_; }

  template <class Message>
  void add(OutputKind kind, const Name& source, const Message& message) {
    commit(kind, source, encode(message, free_space()));
  }
  void add(OutputKind kind) { commit(kind, Name(), 0, true); }
  void add_log(std::string_view line);

 private:
  std::span<std::uint8_t> free_space() { return std::span(arena_).subspan(used_); }
  void commit(OutputKind kind, const Name& source, std::size_t size, bool may_be_empty = false);

  FixedVec<Output, 96> items_;
  std::array<std::uint8_t, 20 * max_frame_bytes> arena_{};
  std::size_t used_ = 0;
  bool overflowed_ = false;
};

}  // namespace fairlead
