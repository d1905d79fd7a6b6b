#include "writer.hpp"

#include <algorithm>
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

void Writer::byte(std::uint8_t value) { raw(&value, 1); }

void Writer::big_endian(std::uint64_t value, std::size_t width) {
  for (std::size_t i = width; i-- > 0;) byte(static_cast<std::uint8_t>(value >> (8 * i)));
}

void Writer::unsigned_number(std::uint64_t value) {
  if (value < 0x80) {
    byte(static_cast<std::uint8_t>(value));
  } else if (value <= 0xFF) {
    byte(0xCC);
    big_endian(value, 1);
  } else if (value <= 0xFFFF) {
    byte(0xCD);
    big_endian(value, 2);
  } else if (value <= 0xFFFFFFFF) {
    byte(0xCE);
    big_endian(value, 4);
  } else {
    byte(0xCF);
    big_endian(value, 8);
  }
}

void Writer::signed_number(std::int64_t value) {
  const auto bits = static_cast<std::uint64_t>(value);
  if (value >= 0x80) {
    unsigned_number(bits);
  } else if (value >= -32) {
    byte(static_cast<std::uint8_t>(bits));
  } else if (value >= INT8_MIN) {
    byte(0xD0);
    big_endian(bits, 1);
  } else if (value >= INT16_MIN) {
    byte(0xD1);
    big_endian(bits, 2);
  } else if (value >= INT32_MIN) {
    byte(0xD2);
    big_endian(bits, 4);
  } else {
    byte(0xD3);
    big_endian(bits, 8);
  }
}

void Writer::number(double value) {
  byte(0xCB);
  big_endian(std::bit_cast<std::uint64_t>(value), 8);
}

void Writer::text(std::string_view value) {
  const std::size_t size = value.size();
  if (size < 32) {
    byte(static_cast<std::uint8_t>(0xA0U | size));
  } else if (size <= 0xFF) {
    byte(0xD9);
    big_endian(size, 1);
  } else {
    byte(0xDA);  // no text of the gate is longer than its 256 bytes
    big_endian(size, 2);
  }
  raw(value.data(), size);
}

void Writer::binary(Bytes value) {
  const std::size_t size = value.size();
  if (size <= 0xFF) {
    byte(0xC4);
    big_endian(size, 1);
  } else if (size <= 0xFFFF) {
    byte(0xC5);
    big_endian(size, 2);
  } else {
    byte(0xC6);
    big_endian(size, 4);
  }
  raw(value.data(), size);
}

void Writer::array(std::size_t count) {
  if (count < 16) {
    byte(static_cast<std::uint8_t>(0x90U | count));
  } else {
    byte(0xDC);  // no list of the gate reaches 65,536 elements
    big_endian(count, 2);
  }
}

}  // namespace fairlead
