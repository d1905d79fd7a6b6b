// Writes msgpack into a caller's buffer, always in the shortest form, as Python's msgspec does.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "fairlead_safety/fixed.hpp"

namespace fairlead {

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
  void byte(std::uint8_t value);
  void big_endian(std::uint8_t lead, std::uint64_t value, std::size_t width);
  void raw(const void* data, std::size_t count);

  std::span<std::uint8_t> buffer_;
  std::size_t size_ = 0;
  bool overflow_ = false;
};

}  // namespace fairlead
