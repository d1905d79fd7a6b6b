#include "core/wire/msgpack.hpp"

#include <algorithm>
#include <array>
#include <bit>

namespace fairlead {
namespace {

// Length of the UTF-8 character at `text[i]`, 0 if there is no valid one.
std::size_t character_length(Bytes text, std::size_t i) {
  const std::uint8_t lead = text[i];
  if (lead < 0x80) return 1;
  if (lead < 0xC2 || lead > 0xF4) return 0;
  const std::size_t length = lead < 0xE0 ? 2 : lead < 0xF0 ? 3 : 4;
  if (text.size() - i < length) return 0;
  // After some leads less is left for the second byte: what is below is overlong, above are the
  // surrogates, or nothing (U+10FFFF is the last character).
  int lowest = lead == 0xE0 ? 0xA0 : lead == 0xF0 ? 0x90 : 0x80;
  int highest = lead == 0xED ? 0x9F : lead == 0xF4 ? 0x8F : 0xBF;
  for (std::size_t k = 1; k < length; ++k) {
    if (text[i + k] < lowest || text[i + k] > highest) return 0;
    lowest = 0x80;
    highest = 0xBF;
  }
  return length;
}

bool is_utf8(Bytes text) {
  for (std::size_t i = 0; i < text.size();) {
    const std::size_t length = character_length(text, i);
    if (length == 0) return false;
    i += length;
  }
  return true;
}

}  // namespace

std::uint8_t Reader::byte() {
  const Bytes one = take(1);
  return one.empty() ? std::uint8_t{0} : one.front();
}

Bytes Reader::take(std::uint64_t count) {
  // The comparison is in 64 bits: a length of 2^32 - 1 must not wrap.
  if (count > rest_.size()) {
    fail(FrameFault::cut_short);
    return {};
  }
  const Bytes taken = rest_.first(static_cast<std::size_t>(count));
  rest_ = rest_.subspan(static_cast<std::size_t>(count));
  return taken;
}

std::uint64_t Reader::big_endian(std::size_t width) {
  std::uint64_t value = 0;
  for (const std::uint8_t part : take(width)) value = (value << 8U) | part;
  return value;
}

std::uint64_t Reader::unsigned_number(std::uint64_t highest) {
  const std::uint8_t lead = byte();
  std::uint64_t value = lead;
  if (lead >= 0xCC && lead <= 0xCF)
    value = big_endian(std::size_t{1} << (lead - 0xCCU));
  else if (lead >= 0x80)
    fail(FrameFault::wrong_type);
  if (value > highest) fail(FrameFault::wrong_type);
  return ok() ? value : 0;
}

std::int64_t Reader::signed_number() {
  const std::uint8_t lead = byte();
  if (lead < 0x80 || lead >= 0xE0) return static_cast<std::int8_t>(lead);
  if (lead >= 0xCC && lead <= 0xCF) {
    const auto value = static_cast<std::int64_t>(big_endian(std::size_t{1} << (lead - 0xCCU)));
    if (value >= 0) return value;  // a larger one does not fit
  } else if (lead >= 0xD0 && lead <= 0xD3) {
    const std::size_t width = std::size_t{1} << (lead - 0xD0U);
    const std::uint64_t sign = std::uint64_t{1} << (8 * width - 1);
    // Sign extension, well defined in unsigned arithmetic.
    return static_cast<std::int64_t>((big_endian(width) ^ sign) - sign);
  }
  fail(FrameFault::wrong_type);
  return 0;
}

double Reader::number() {
  if (!rest_.empty() && rest_.front() == 0xCB) {
    byte();
    return std::bit_cast<double>(big_endian(8));
  }
  if (!rest_.empty() && rest_.front() == 0xCA) {
    byte();
    return static_cast<double>(std::bit_cast<float>(static_cast<std::uint32_t>(big_endian(4))));
  }
  return static_cast<double>(signed_number());
}

bool Reader::boolean() {
  const std::uint8_t lead = byte();
  if (lead != 0xC2 && lead != 0xC3) fail(FrameFault::wrong_type);
  return ok() && lead == 0xC3;
}

std::string_view Reader::text() {
  const std::uint8_t lead = byte();
  std::uint64_t length = lead & 0x1FU;
  if (lead >= 0xD9 && lead <= 0xDB)
    length = big_endian(std::size_t{1} << (lead - 0xD9U));
  else if (lead < 0xA0 || lead > 0xBF)
    fail(FrameFault::wrong_type);
  const Bytes bytes = take(length);
  if (!is_utf8(bytes)) fail(FrameFault::text);
  return ok() ? std::string_view(reinterpret_cast<const char*>(bytes.data()), bytes.size())
              : std::string_view();
}

Bytes Reader::binary() {
  const std::uint8_t lead = byte();
  if (lead >= 0xC4 && lead <= 0xC6) return take(big_endian(std::size_t{1} << (lead - 0xC4U)));
  fail(FrameFault::wrong_type);
  return {};
}

std::size_t Reader::array() {
  const std::uint8_t lead = byte();
  if (lead >= 0x90 && lead <= 0x9F) return lead & 0x0FU;
  if (lead != 0xDC && lead != 0xDD) fail(FrameFault::wrong_type);
  return ok() ? static_cast<std::size_t>(big_endian(lead == 0xDC ? 2 : 4)) : 0;
}

void Writer::raw(const void* data, std::size_t count) {
  if (overflow_ || count > buffer_.size() - size_) {
    overflow_ = true;
    return;
  }
  std::copy_n(static_cast<const std::uint8_t*>(data), count, buffer_.data() + size_);
  size_ += count;
}

void Writer::big_endian(std::uint8_t lead, std::uint64_t value, std::size_t width) {
  std::array<std::uint8_t, 9> bytes{lead};
  for (std::size_t i = 1; i <= width; ++i)
    bytes[i] = static_cast<std::uint8_t>(value >> (8 * (width - i)));
  raw(bytes.data(), 1 + width);
}

void Writer::unsigned_number(std::uint64_t value) {
  if (value < 0x80) return byte(static_cast<std::uint8_t>(value));
  if (value <= 0xFF) return big_endian(0xCC, value, 1);
  if (value <= 0xFFFF) return big_endian(0xCD, value, 2);
  if (value <= 0xFFFFFFFF) return big_endian(0xCE, value, 4);
  big_endian(0xCF, value, 8);
}

void Writer::signed_number(std::int64_t value) {
  const auto bits = static_cast<std::uint64_t>(value);
  if (value >= 0) return unsigned_number(bits);
  if (value >= -32) return byte(static_cast<std::uint8_t>(bits));
  if (value >= INT8_MIN) return big_endian(0xD0, bits, 1);
  if (value >= INT16_MIN) return big_endian(0xD1, bits, 2);
  if (value >= INT32_MIN) return big_endian(0xD2, bits, 4);
  big_endian(0xD3, bits, 8);
}

void Writer::number(double value) { big_endian(0xCB, std::bit_cast<std::uint64_t>(value), 8); }

void Writer::text(std::string_view value) {
  const std::size_t size = value.size();
  if (size < 32)
    byte(static_cast<std::uint8_t>(0xA0U | size));
  else if (size <= 0xFF)
    big_endian(0xD9, size, 1);
  else
    big_endian(0xDA, size, 2);  // no text of the gate is longer than its 256 bytes
  raw(value.data(), size);
}

void Writer::binary(Bytes value) {
  const std::size_t size = value.size();
  if (size <= 0xFF)
    big_endian(0xC4, size, 1);
  else if (size <= 0xFFFF)
    big_endian(0xC5, size, 2);
  else
    big_endian(0xC6, size, 4);
  raw(value.data(), size);
}

void Writer::array(std::size_t count) {
  if (count < 16) return byte(static_cast<std::uint8_t>(0x90U | count));
  big_endian(0xDC, count, 2);  // no list of the gate reaches 65,536 elements
}

}  // namespace fairlead
