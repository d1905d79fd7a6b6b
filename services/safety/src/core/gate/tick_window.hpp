// Counting events within a window of ticks.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace fairlead {

/// The last N events by tick. N must be at least the count that matters.
template <std::size_t N>
class TickWindow {
 public:
  static constexpr std::size_t capacity = N;

  void add(std::uint64_t tick) {
    ticks_[next_] = tick;
    next_ = (next_ + 1) % N;
    if (size_ < N) ++size_;
  }
  /// Events in the `window` ticks that end with `now`.
  [[nodiscard]] std::size_t count(std::uint64_t now, std::uint64_t window) const {
    std::size_t found = 0;
    for (std::size_t i = 0; i < size_; ++i)
      if (now - ticks_[i] < window) ++found;
    return found;
  }
  /// A new session counts its ticks from 1: what happened before happened at its tick 0.
  void rebase() {
    for (std::uint64_t& tick : ticks_) tick = 0;
  }

 private:
  std::array<std::uint64_t, N> ticks_{};
  std::size_t size_ = 0;
  std::size_t next_ = 0;
};

}  // namespace fairlead
