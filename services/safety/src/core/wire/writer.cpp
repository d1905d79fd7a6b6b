#include "core/wire/writer.hpp"

#include <algorithm>
#include <array>
#include <bit>

namespace fairlead {

void Writer::raw(const void* data, std::size_t count) {
  if (overflow_ || count > buffer_.size() - size_) {
    overflow_ = true;
    return;
  }
  std::copy_n(static_cast<const std::uint8_t*>(data), count, buffer_.data() + size_);
  size_ += count;
}

void Writer::byte(std::uint8_t value) {
  if (overflow_ || size_ == buffer_.size()) {
    overflow_ = true;
    return;
  }
  buffer_[size_++] = value;
}

void Writer::big_endian(std::uint8_t lead, std::uint64_t value, std::size_t width) {
  std::array<std::uint8_t, 9> bytes{lead};
  for (std::size_t i = 1; i <= width; ++i)
    bytes[i] = static_cast<std::uint8_t>(value >> (8 * (width - i)));
  raw(bytes.data(), 1 + width);
}

void Writer::unsigned_number(std::uint64_t value) {
  if (value < 0x80) {
    byte(static_cast<std::uint8_t>(value));
  } else if (value <= 0xFF) {
    big_endian(0xCC, value, 1);
  } else if (value <= 0xFFFF) {
    big_endian(0xCD, value, 2);
  } else if (value <= 0xFFFFFFFF) {
    big_endian(0xCE, value, 4);
  } else {
    big_endian(0xCF, value, 8);
  }
}

void Writer::signed_number(std::int64_t value) {
  const auto bits = static_cast<std::uint64_t>(value);
  if (value >= 0x80) {
    unsigned_number(bits);
  } else if (value >= -32) {
    byte(static_cast<std::uint8_t>(bits));
  } else if (value >= INT8_MIN) {
    big_endian(0xD0, bits, 1);
  } else if (value >= INT16_MIN) {
    big_endian(0xD1, bits, 2);
  } else if (value >= INT32_MIN) {
    big_endian(0xD2, bits, 4);
  } else {
    big_endian(0xD3, bits, 8);
  }
}

void Writer::number(double value) { big_endian(0xCB, std::bit_cast<std::uint64_t>(value), 8); }

void Writer::text(std::string_view value) {
  const std::size_t size = value.size();
  if (size < 32) {
    byte(static_cast<std::uint8_t>(0xA0U | size));
  } else if (size <= 0xFF) {
    big_endian(0xD9, size, 1);
  } else {
    big_endian(0xDA, size, 2);  // no text of the gate is longer than its 256 bytes
  }
  raw(value.data(), size);
}

void Writer::binary(Bytes value) {
  const std::size_t size = value.size();
  if (size <= 0xFF) {
    big_endian(0xC4, size, 1);
  } else if (size <= 0xFFFF) {
    big_endian(0xC5, size, 2);
  } else {
    big_endian(0xC6, size, 4);
  }
  raw(value.data(), size);
}

void Writer::array(std::size_t count) {
  if (count < 16) {
    byte(static_cast<std::uint8_t>(0x90U | count));
  } else {
    big_endian(0xDC, count, 2);  // no list of the gate reaches 65,536 elements
  }
}

}  // namespace fairlead
