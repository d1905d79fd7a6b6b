// G050: is what lies in memory still what was put there?
#pragma once

#include <algorithm>
#include <cstdint>

#include "fairlead_safety/crc32.hpp"

namespace fairlead {

/// Reads bytes that must not change over and over, a slice at a time: all of them in about a
/// second, if it is asked every 5 ms. Padding between the fields counts too: it changes as little.
class MemoryGuard {
 public:
  MemoryGuard() = default;
  explicit MemoryGuard(Bytes bytes) : bytes_(bytes), expected_(crc32(bytes)), found_(expected_) {}

  /// Read the next slice if it is due. True when a whole pass has just ended.
  bool read_on(std::uint64_t now_ns) {
    if (now_ns - read_ns_ < pause_ns) return false;
    read_ns_ = now_ns;
    const std::size_t size = std::min(slice_size(), bytes_.size() - at_);
    crc_ = crc32(bytes_.subspan(at_, size), crc_);
    at_ += size;
    if (at_ < bytes_.size()) return false;
    found_ = crc_;
    crc_ = 0;
    at_ = 0;
    return true;
  }
  /// Of the newest whole pass.
  [[nodiscard]] bool intact() const { return found_ == expected_; }
  [[nodiscard]] std::uint32_t found() const { return found_; }
  [[nodiscard]] std::uint32_t expected() const { return expected_; }

 private:
  static constexpr std::uint64_t pause_ns = 4'000'000;
  static constexpr std::size_t slices = 200;
  [[nodiscard]] std::size_t slice_size() const { return (bytes_.size() + slices - 1) / slices; }

  Bytes bytes_;
  std::uint32_t expected_ = 0;
  std::uint32_t found_ = 0;
  std::uint32_t crc_ = 0;  // of this pass up to `at_`
  std::size_t at_ = 0;
  std::uint64_t read_ns_ = 0;
};

/// The bytes of an object that holds all it has in place: numbers and texts, no pointers to more.
template <class T>
Bytes bytes_of(const T& object) {
  return {reinterpret_cast<const std::uint8_t*>(&object), sizeof object};
}

}  // namespace fairlead
