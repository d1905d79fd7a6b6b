// How a message says what it consists of: its fields, once, in wire order.
//
// Each struct lists its fields in `fields()`; the codec walks that list in both directions. A
// top-level message has a `type_id` (element 0 on the wire); element 1 is its version.
#pragma once

#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <tuple>

#include "fairlead_safety/fixed.hpp"

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

}  // namespace fairlead
