// Containers of fixed capacity: the gate allocates nothing once it has started.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <span>
#include <string_view>

namespace fairlead {

/// A vector of at most N elements, stored in place.
template <class T, std::size_t N>
class FixedVec {
 public:
  static constexpr std::size_t capacity = N;

  /// Append; false (and nothing appended) when full. The caller decides what full means.
  [[nodiscard]] bool push_back(const T& item) {
    if (size_ == N) return false;
    items_[size_++] = item;
    return true;
  }
  /// Become `size` default elements; false when that exceeds the capacity.
  [[nodiscard]] bool resize(std::size_t size) {
    if (size > N) return false;
    for (std::size_t i = size_; i < size; ++i) items_[i] = T{};
    size_ = size;
    return true;
  }
  void erase_at(std::size_t index) {
    for (std::size_t i = index + 1; i < size_; ++i) items_[i - 1] = items_[i];
    --size_;
  }
  void clear() { size_ = 0; }

  [[nodiscard]] std::size_t size() const { return size_; }
  [[nodiscard]] bool empty() const { return size_ == 0; }
  T& operator[](std::size_t i) { return items_[checked(i)]; }
  const T& operator[](std::size_t i) const { return items_[checked(i)]; }
  T* begin() { return items_.data(); }
  T* end() { return items_.data() + size_; }
  const T* begin() const { return items_.data(); }
  const T* end() const { return items_.data() + size_; }

  [[nodiscard]] bool contains(const T& wanted) const {
    for (const T& item : *this)
      if (item == wanted) return true;
    return false;
  }
  friend bool operator==(const FixedVec& a, const FixedVec& b) {
    if (a.size_ != b.size_) return false;
    for (std::size_t i = 0; i < a.size_; ++i)
      if (!(a.items_[i] == b.items_[i])) return false;
    return true;
  }

 private:
  // A gate that reads beyond a list knows nothing any more: it ends, and the robot holds.
  [[nodiscard]] std::size_t checked(std::size_t i) const {
    if (i >= size_) std::abort();  // GCOVR_EXCL_LINE: in every instance
    return i;
  }

  std::array<T, N> items_{};
  std::size_t size_ = 0;
};

/// UTF-8 text of at most N bytes, stored in place. What does not fit is cut between characters.
template <std::size_t N>
class FixedText {
 public:
  static constexpr std::size_t capacity = N;

  FixedText() = default;
  FixedText(std::string_view text) { append(text); }               // NOLINT: a text is a text
  FixedText(const char* text) { append(std::string_view(text)); }  // NOLINT

  FixedText& append(std::string_view text) {
    std::size_t count = text.size() <= N - size_ ? text.size() : N - size_;
    // Never end inside a multi-byte character: readers refuse text that is not UTF-8.
    while (count < text.size() && count > 0 &&
           (static_cast<unsigned char>(text[count]) & 0xC0U) == 0x80U)
      --count;
    if (count > 0) std::memcpy(bytes_.data() + size_, text.data(), count);
    size_ += count;
    return *this;
  }
  void clear() { size_ = 0; }

  [[nodiscard]] std::string_view view() const { return {bytes_.data(), size_}; }
  [[nodiscard]] std::size_t size() const { return size_; }
  [[nodiscard]] bool empty() const { return size_ == 0; }
  friend bool operator==(const FixedText& a, const FixedText& b) { return a.view() == b.view(); }
  friend bool operator==(const FixedText& a, std::string_view b) { return a.view() == b; }
  friend bool operator==(const FixedText& a, const char* b) {
    return a.view() == std::string_view(b);
  }

 private:
  std::array<char, N> bytes_{};
  std::size_t size_ = 0;
};

/// An identifier: robot, part, joint, frame, source. Longer ones are refused, never cut.
using Name = FixedText<64>;
/// Prose for people: causes, reasons, fixes. Longer ones are cut.
using Text = FixedText<256>;
/// SHA-256 of an identity or a file; all zero means none.
using Hash = std::array<std::uint8_t, 32>;

using Bytes = std::span<const std::uint8_t>;

/// The last N events by tick. N must be at least the count that matters.
template <std::size_t N>
class TickWindow {
 public:
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
  /// A new session counts its ticks from 1, as if its tick 0 were the last of the one before: what
  /// happened keeps its age. Ticks before 0 wrap around, and so does `count`.
  void rebase(std::uint64_t last_tick) {
    for (std::uint64_t& tick : ticks_) tick -= last_tick;
  }

 private:
  std::array<std::uint64_t, N> ticks_{};
  std::size_t size_ = 0;
  std::size_t next_ = 0;
};

}  // namespace fairlead
