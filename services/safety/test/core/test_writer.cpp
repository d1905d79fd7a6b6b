// The shortest msgpack form of everything, at both sides of each change of form.

#include <doctest/doctest.h>

#include <string>
#include <vector>

#include "core/wire/msgpack.hpp"

using namespace fairlead;

namespace {

using Frame = std::vector<std::uint8_t>;

// What `write` writes, at most `room` bytes.
Frame written(auto write, std::size_t room = 70'000) {
  Frame frame(room);
  Writer writer{frame};
  write(writer);
  frame.resize(writer.size());
  return frame;
}

Frame unsigned_frame(std::uint64_t value) {
  return written([value](Writer& out) { out.unsigned_number(value); });
}

Frame signed_frame(std::int64_t value) {
  return written([value](Writer& out) { out.signed_number(value); });
}

// The bytes before the content.
Frame head_of_text(std::size_t size) {
  Frame frame = written([size](Writer& out) { out.text(std::string(size, 'x')); });
  REQUIRE(frame.size() > size);
  frame.resize(frame.size() - size);
  return frame;
}

Frame head_of_bytes(std::size_t size) {
  Frame frame = written([size](Writer& out) { out.binary(Frame(size, 5)); });
  REQUIRE(frame.size() > size);
  frame.resize(frame.size() - size);
  return frame;
}

}  // namespace

TEST_CASE("unsigned numbers take the shortest form") {
  CHECK(unsigned_frame(0) == Frame{0x00});
  CHECK(unsigned_frame(0x7F) == Frame{0x7F});
  CHECK(unsigned_frame(0x80) == Frame{0xCC, 0x80});
  CHECK(unsigned_frame(0xFF) == Frame{0xCC, 0xFF});
  CHECK(unsigned_frame(0x100) == Frame{0xCD, 1, 0});
  CHECK(unsigned_frame(0xFFFF) == Frame{0xCD, 0xFF, 0xFF});
  CHECK(unsigned_frame(0x10000) == Frame{0xCE, 0, 1, 0, 0});
  CHECK(unsigned_frame(0xFFFFFFFF) == Frame{0xCE, 0xFF, 0xFF, 0xFF, 0xFF});
  CHECK(unsigned_frame(0x100000000) == Frame{0xCF, 0, 0, 0, 1, 0, 0, 0, 0});
}

TEST_CASE("signed numbers take the shortest form") {
  CHECK(signed_frame(0) == Frame{0x00});
  CHECK(signed_frame(1) == Frame{0x01});
  CHECK(signed_frame(127) == Frame{0x7F});
  CHECK(signed_frame(128) == Frame{0xCC, 0x80});
  CHECK(signed_frame(200) == Frame{0xCC, 200});
  CHECK(signed_frame(-1) == Frame{0xFF});
  CHECK(signed_frame(-32) == Frame{0xE0});
  CHECK(signed_frame(-33) == Frame{0xD0, 0xDF});
  CHECK(signed_frame(-128) == Frame{0xD0, 0x80});
  CHECK(signed_frame(-129) == Frame{0xD1, 0xFF, 0x7F});
  CHECK(signed_frame(-32768) == Frame{0xD1, 0x80, 0});
  CHECK(signed_frame(-32769) == Frame{0xD2, 0xFF, 0xFF, 0x7F, 0xFF});
  CHECK(signed_frame(INT32_MIN) == Frame{0xD2, 0x80, 0, 0, 0});
  CHECK(signed_frame(std::int64_t{INT32_MIN} - 1) ==
        Frame{0xD3, 0xFF, 0xFF, 0xFF, 0xFF, 0x7F, 0xFF, 0xFF, 0xFF});
}

TEST_CASE("texts, bytes and lists take the shortest head") {
  CHECK(head_of_text(0) == Frame{0xA0});
  CHECK(head_of_text(31) == Frame{0xBF});
  CHECK(head_of_text(32) == Frame{0xD9, 32});
  CHECK(head_of_text(255) == Frame{0xD9, 255});
  CHECK(head_of_text(256) == Frame{0xDA, 1, 0});
  CHECK(head_of_bytes(0) == Frame{0xC4, 0});
  CHECK(head_of_bytes(255) == Frame{0xC4, 255});
  CHECK(head_of_bytes(256) == Frame{0xC5, 1, 0});
  CHECK(head_of_bytes(65535) == Frame{0xC5, 255, 255});
  CHECK(head_of_bytes(65536) == Frame{0xC6, 0, 1, 0, 0});
  const auto array = [](std::size_t count) {
    return written([count](Writer& out) { out.array(count); });
  };
  CHECK(array(0) == Frame{0x90});
  CHECK(array(15) == Frame{0x9F});
  CHECK(array(16) == Frame{0xDC, 0, 16});
}

TEST_CASE("a buffer that is filled to its last byte is enough; one byte less is nothing at all") {
  const auto three = [](Writer& out) { out.unsigned_number(0x100); };
  CHECK(written(three, 3) == Frame{0xCD, 1, 0});
  CHECK(written(three, 2).empty());
  const auto late = [](Writer& out) {
    out.text("abc");
    out.boolean(true);  // would fit again, but the frame is spoilt
  };
  CHECK(written(late, 3).empty());
  CHECK(written([](Writer& out) { out.text(""); }, 1) == Frame{0xA0});
}

TEST_CASE("a single byte that finds no room leaves nothing of what was before it") {
  const auto text_and_flag = [](Writer& out) {
    out.text("ab");
    out.boolean(true);
  };
  CHECK(written(text_and_flag, 4).size() == 4);
  CHECK(written(text_and_flag, 3).empty());
}
