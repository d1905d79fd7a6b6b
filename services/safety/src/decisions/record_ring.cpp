#include "decisions/record_ring.hpp"

#include <cstring>

namespace fairlead {
namespace {

constexpr std::uint32_t kWrap = 0xFFFFFFFF;

}  // namespace

void RecordRing::put_length(std::size_t position, Length length) {
  std::memcpy(bytes_.data() + place(position), &length, sizeof length);
}

RecordRing::Length RecordRing::length_at(std::size_t position) const {
  Length length = 0;
  std::memcpy(&length, bytes_.data() + place(position), sizeof length);
  return length;
}

std::span<std::uint8_t> RecordRing::reserve(std::size_t size) {
  const std::size_t needed = sizeof(Length) + size;
  const std::size_t written = written_.load(std::memory_order_relaxed);
  const std::size_t to_end = bytes_.size() - place(written);
  const std::size_t skipped = needed > to_end ? to_end : 0;
  const std::size_t in_use = written - read_.load(std::memory_order_acquire);
  if (in_use + skipped + needed > bytes_.size()) return {};
  if (skipped >= sizeof(Length)) put_length(written, kWrap);  // less than that is read as one too
  reserved_ = written + skipped;
  return std::span(bytes_).subspan(place(reserved_) + sizeof(Length), size);
}

void RecordRing::commit(std::size_t size) {
  put_length(reserved_, static_cast<Length>(size));
  written_.store(reserved_ + sizeof(Length) + size, std::memory_order_release);
}

Bytes RecordRing::front() {
  std::size_t read = read_.load(std::memory_order_relaxed);
  if (read == written_.load(std::memory_order_acquire)) return {};
  const std::size_t to_end = bytes_.size() - place(read);
  if (to_end < sizeof(Length) || length_at(read) == kWrap) {
    read += to_end;
    read_.store(read, std::memory_order_release);
  }
  return Bytes(bytes_).subspan(place(read) + sizeof(Length), length_at(read));
}

void RecordRing::pop() {
  const std::size_t read = read_.load(std::memory_order_relaxed);
  read_.store(read + sizeof(Length) + length_at(read), std::memory_order_release);
}

}  // namespace fairlead
