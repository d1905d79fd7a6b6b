// The wire at its edges: the longest of each short form, the first of the next, and what is none.

#include <doctest/doctest.h>

#include <algorithm>
#include <string>

#include "boundary.hpp"
#include "chunk_builder.hpp"
#include "fairlead_safety/query_messages.hpp"

using namespace fairlead;
using namespace fairlead::test;

namespace {

using Frame = std::vector<std::uint8_t>;

// A verdict's `row`, its only signed number, written as these bytes.
FrameFault row_written(const Frame& bytes, std::int64_t& row) {
  Verdict verdict;
  verdict.row = -7;
  verdict.config_hash = hash_of(9);
  Frame frame = frame_of(verdict);
  const auto place = std::find(frame.begin(), frame.end(), 0xF9);
  REQUIRE(place != frame.end());
  const auto next = frame.erase(place);
  frame.insert(next, bytes.begin(), bytes.end());
  const FrameFault fault = decode(frame, verdict);
  row = verdict.row;
  return fault;
}

// A lease's `state`, a number of 8 bits, written as these bytes.
FrameFault state_written(const Frame& bytes, std::uint8_t& state) {
  Lease lease;
  lease.config_hash = hash_of(0x55);
  lease.state = 7;
  Frame frame = frame_of(lease);
  const auto hash_end = std::find(frame.rbegin(), frame.rend(), 0x55).base();
  REQUIRE(*hash_end == 7);
  const auto next = frame.erase(hash_end);
  frame.insert(next, bytes.begin(), bytes.end());
  const FrameFault fault = decode(frame, lease);
  state = lease.state;
  return fault;
}

std::size_t size_of_row(std::int64_t row) {
  Verdict verdict;
  verdict.row = row;
  Verdict zero;
  zero.row = 0;
  return frame_of(verdict).size() - frame_of(zero).size() + 1;
}

// An Arm whose `by` starts with these bytes.
FrameFault by_written(const Frame& bytes) {
  Frame frame{0x93, 23, 1};
  frame.insert(frame.end(), bytes.begin(), bytes.end());
  Arm arming;
  return decode(frame, arming);
}

FrameFault block_written(const Frame& head, std::size_t size) {
  Frame frame = frame_of(ChunkBuilder().scalar(0, Mode::gripper_position, {0.5}).chunk);
  const Frame block{0xC4, 8};
  const auto place = std::search(frame.begin(), frame.end(), block.begin(), block.end());
  REQUIRE(place != frame.end());
  const auto next = frame.erase(place, place + 2 + 8);
  Frame written = head;
  written.resize(head.size() + size, 0);
  frame.insert(next, written.begin(), written.end());
  ActionChunk chunk;
  return decode(frame, chunk);
}

}  // namespace

TEST_CASE("a signed number is read from every width, and from nothing else") {
  std::int64_t row = 0;
  const std::vector<std::pair<Frame, std::int64_t>> good{
      {{0x7F}, 127},
      {{0xE0}, -32},
      {{0xFF}, -1},
      {{0xCC, 0x80}, 128},
      {{0xCF, 0x7F, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF}, INT64_MAX},
      {{0xD0, 0x80}, -128},
      {{0xD1, 0x80, 0x00}, INT16_MIN},
      {{0xD2, 0x80, 0x00, 0x00, 0x00}, INT32_MIN},
      {{0xD3, 0x80, 0, 0, 0, 0, 0, 0, 0}, INT64_MIN}};
  for (const auto& [bytes, value] : good) {
    CHECK(row_written(bytes, row) == FrameFault::none);
    CHECK(row == value);
  }
  for (const std::uint8_t lead : Frame{0x80, 0xC0, 0xCA, 0xCB, 0xD4, 0xD9, 0xDC, 0xDF})
    CHECK(row_written({lead, 0, 0, 0, 0, 0, 0, 0, 0}, row) == FrameFault::wrong_type);
  CHECK(row_written({0xCF, 0x80, 0, 0, 0, 0, 0, 0, 0}, row) == FrameFault::wrong_type);
}

TEST_CASE("an unsigned number of 8 bits is at most 255, in any width, and no other type") {
  std::uint8_t state = 0;
  CHECK(state_written({0x7F}, state) == FrameFault::none);
  CHECK(state_written({0xCC, 0xFF}, state) == FrameFault::none);
  CHECK(state == 255);
  CHECK(state_written({0xCF, 0, 0, 0, 0, 0, 0, 0, 5}, state) == FrameFault::none);
  CHECK(state == 5);
  CHECK(state_written({0xCD, 0x01, 0x00}, state) == FrameFault::wrong_type);
  for (const std::uint8_t lead : Frame{0x80, 0x81, 0xC0, 0xCB, 0xD0, 0xE0, 0xFF})
    CHECK(state_written({lead, 1}, state) == FrameFault::wrong_type);
  CHECK(state_written({0x80}, state) == FrameFault::wrong_type);
}

TEST_CASE("a signed number is written as short as it can be") {
  for (const auto& [row, size] :
       std::vector<std::pair<std::int64_t, std::size_t>>{{-1, 1},
                                                         {-32, 1},
                                                         {-33, 2},
                                                         {INT8_MIN, 2},
                                                         {INT8_MIN - 1, 3},
                                                         {INT16_MIN, 3},
                                                         {INT16_MIN - 1, 5},
                                                         {INT32_MIN, 5},
                                                         {std::int64_t{INT32_MIN} - 1, 9},
                                                         {0, 1},
                                                         {127, 1},
                                                         {128, 2},
                                                         {255, 2},
                                                         {256, 3},
                                                         {65535, 3},
                                                         {65536, 5},
                                                         {4294967295, 5},
                                                         {4294967296, 9}})
    CHECK(size_of_row(row) == size);
}

TEST_CASE("a text is written as short as it can be, and read from every form of text only") {
  const auto size = [](std::size_t count) {
    Arm arming;
    arming.by = std::string_view(std::string(256, 'a')).substr(0, count);
    return frame_of(arming).size() - 3 - count;
  };
  CHECK(size(0) == 1);
  CHECK(size(31) == 1);
  CHECK(size(32) == 2);
  CHECK(size(255) == 2);
  CHECK(size(256) == 3);
  CHECK(by_written({0xA1, 'a'}) == FrameFault::none);
  CHECK(by_written({0xD9, 1, 'a'}) == FrameFault::none);
  CHECK(by_written({0xDA, 0, 1, 'a'}) == FrameFault::none);
  CHECK(by_written({0xDB, 0, 0, 0, 1, 'a'}) == FrameFault::none);
  for (const std::uint8_t lead : Frame{0x00, 0x9F, 0xC0, 0xC4, 0xD8, 0xDC, 0xE0})
    CHECK(by_written({lead, 0, 0, 0, 0}) == FrameFault::wrong_type);
}

TEST_CASE("a block of bytes is written as short as it can be, and read from every form") {
  CHECK(block_written({0xC4, 8}, 8) == FrameFault::none);
  CHECK(block_written({0xC5, 0, 8}, 8) == FrameFault::none);
  CHECK(block_written({0xC6, 0, 0, 0, 8}, 8) == FrameFault::none);
  CHECK(block_written({0xC4, 7}, 7) == FrameFault::wrong_type);
  for (const std::uint8_t lead : Frame{0x00, 0xA0, 0xC3, 0xC7, 0xD9, 0xC0})
    CHECK(block_written({lead, 8}, 8) == FrameFault::wrong_type);
  const auto head = [](std::size_t count) {
    const std::vector<double> numbers(count, 1.0);
    ActionPart part;
    part.values = NumberView(Bytes(reinterpret_cast<const std::uint8_t*>(numbers.data()),
                                   numbers.size() * sizeof(double)));
    ActionChunk chunk;
    const std::size_t before = frame_of(chunk).size();
    (void)chunk.parts.push_back(part);
    return frame_of(chunk).size() - before - 8 * count;
  };
  CHECK(head(32) == head(31) + 1);    // 256 bytes
  CHECK(head(8191) == head(32));      // 65,528 bytes
  CHECK(head(8192) == head(32) + 2);  // 65,536 bytes
}

TEST_CASE("a truth value is one of two bytes") {
  GateStatus status;
  status.lockstep_allowed = true;
  status.config_hash = status.robot_hash = hash_of(0x55);
  Frame frame = frame_of(status);
  const auto place = std::find(frame.begin(), frame.end(), 0xC3);
  REQUIRE(place != frame.end());
  for (const std::uint8_t other : Frame{0xC0, 0xC1, 0xC4, 0x00, 0x01}) {
    *place = other;
    CHECK(decode(frame, status) == FrameFault::wrong_type);
  }
  *place = 0xC2;
  CHECK(decode(frame, status) == FrameFault::none);
  CHECK_FALSE(status.lockstep_allowed);
}

TEST_CASE("a hash has 32 bytes, and a record as many fields as it has") {
  JointState state;
  state.robot_hash.fill(0x5A);
  (void)state.acted.push_back(Acted{2, 7, 1});
  const Frame whole = frame_of(state);
  REQUIRE(decode(whole, state) == FrameFault::none);

  const Frame head{0xC4, 0x20, 0x5A};
  const auto at = std::search(whole.begin(), whole.end(), head.begin(), head.end());
  REQUIRE(at != whole.end());
  const auto place = at - whole.begin();
  Frame shorter = whole;
  shorter[static_cast<std::size_t>(place) + 1] = 0x1F;
  shorter.erase(shorter.begin() + place + 2);
  CHECK(decode(shorter, state) == FrameFault::wrong_type);
  Frame longer = whole;
  longer[static_cast<std::size_t>(place) + 1] = 0x21;
  longer.insert(longer.begin() + place + 2, 0x5A);
  CHECK(decode(longer, state) == FrameFault::wrong_type);

  const Frame act{0x93, 2, 7, 1};
  const auto record = std::search(whole.begin(), whole.end(), act.begin(), act.end());
  REQUIRE(record != whole.end());
  for (const std::uint8_t fields : Frame{0x92, 0x94}) {
    Frame other = whole;
    other[static_cast<std::size_t>(record - whole.begin())] = fields;
    CHECK(decode(other, state) == FrameFault::arity);
  }
}

TEST_CASE("a frame that is too long is at fault at the first byte beyond what is looked at") {
  const Frame frame(max_frame_bytes + 1, 0);
  ActionChunk chunk;
  std::size_t at = 7;
  CHECK(decode(Bytes(frame), chunk, &at) == FrameFault::oversized);
  CHECK(at == max_frame_bytes);
}

TEST_CASE("only an ActionChunk has the head of one") {
  ChunkHead head;
  CHECK(read_chunk_head(ChunkBuilder().frame(), head));
  CHECK_FALSE(read_chunk_head(frame_of(JointState{}), head));
  CHECK_FALSE(read_chunk_head(frame_of(Heartbeat{5}), head));
  CHECK_FALSE(read_chunk_head(Frame{}, head));
}
