// One msgpack frame, read and written.
//
// Reading is a bounded cursor: the first fault sticks, every later read is empty. Writing goes into
// a buffer of the caller, always in the shortest form, as Python's msgspec does.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "fairlead_safety/codec.hpp"
#include "fairlead_safety/fixed.hpp"

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

class Writer {
 public:
  explicit Writer(std::span<std::uint8_t> buffer) : buffer_(buffer) {}

  void unsigned_number(std::uint64_t value);
  void signed_number(std::int64_t value);
  void number(double value);
  void boolean(bool value) { byte(value ? 0xC3 : 0xC2); }
  void text(std::string_view value);
  void binary(Bytes value);
  void array(std::size_t count);

  /// Bytes written, 0 if the buffer was too small.
  [[nodiscard]] std::size_t size() const { return overflow_ ? 0 : size_; }

 private:
  void byte(std::uint8_t value) { raw(&value, 1); }
  void big_endian(std::uint8_t lead, std::uint64_t value, std::size_t width);
  void raw(const void* data, std::size_t count);

  std::span<std::uint8_t> buffer_;
  std::size_t size_ = 0;
  bool overflow_ = false;
};

}  // namespace fairlead
