// A bounded cursor over one msgpack frame. The first fault sticks; every later read is empty.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>

#include "fairlead_safety/codec.hpp"

namespace fairlead {

class Reader {
 public:
  explicit Reader(Bytes frame) : rest_(frame) {}

  std::uint64_t unsigned_number(std::uint64_t highest);
  std::int64_t signed_number();
  double number();  // integers are numbers too: Python writes 20 for 20.0
  bool boolean();
  std::string_view text();
  Bytes binary();
  std::size_t array();  // number of elements that follow

  [[nodiscard]] FrameFault fault() const { return fault_; }
  [[nodiscard]] bool ok() const { return fault_ == FrameFault::none; }
  /// Bytes that were not read when the first fault was found, or yet.
  [[nodiscard]] std::size_t left() const { return ok() ? rest_.size() : left_; }
  [[nodiscard]] bool at_end() const { return rest_.empty(); }
  void fail(FrameFault fault) {
    if (ok()) {
      fault_ = fault;
      left_ = rest_.size();
    }
    rest_ = {};
  }

 private:
  std::uint8_t byte();
  std::uint64_t big_endian(std::size_t width);
  Bytes take(std::uint64_t count);

  Bytes rest_;
  std::size_t left_ = 0;
  FrameFault fault_ = FrameFault::none;
};

}  // namespace fairlead
