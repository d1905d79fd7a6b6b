// A queue of byte records between one thread that must not wait and one that may.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "fairlead_safety/fixed.hpp"

namespace fairlead {

/// One producer, one consumer, no lock, no allocation after construction.
class RecordRing {
 public:
  explicit RecordRing(std::size_t capacity) : bytes_(capacity) {}

  /// Producer: room for one record, empty if there is none. Then `commit` what was used of it.
  std::span<std::uint8_t> reserve(std::size_t size);
  void commit(std::size_t size);

  /// Consumer: the oldest record, empty if there is none; valid until `pop`.
  Bytes front();
  void pop();

 private:
  using Length = std::uint32_t;

  // Positions count bytes since the start; their remainder is the place. A record lies in one
  // piece: `wrap` as its length says that the next one starts at the front again.
  std::size_t place(std::size_t position) const { return position % bytes_.size(); }
  void put_length(std::size_t position, Length length);
  Length length_at(std::size_t position) const;

  std::vector<std::uint8_t> bytes_;
  std::size_t reserved_ = 0;  // the producer's: where the next record starts
  std::atomic<std::size_t> written_{0};
  std::atomic<std::size_t> read_{0};
};

}  // namespace fairlead
