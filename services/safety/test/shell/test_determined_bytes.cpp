// No byte that leaves the gate comes from memory that nobody set.

#include <array>
#include <memory>

#include "core/filled_heap.hpp"
#include "decisions/record.hpp"
#include "decisions/replay.hpp"
#include "fairlead_safety/crc32.hpp"
#include "recorded_sessions.hpp"

using namespace fairlead;
using namespace fairlead::test;

namespace {

// Leaves `fill` where the functions called next have what is theirs.
[[gnu::noinline]] void fill_stack(std::uint8_t fill) {
  std::array<volatile std::uint8_t, 49152> bytes;  // more than a frame of the core may have
  for (volatile std::uint8_t& byte : bytes) byte = fill;
}

// The record of a step as it is written down, and everything that was put out, in one sum.
std::uint32_t sum_of(const Replay& replay, const Record& given, std::uint32_t sum) {
  const std::span ids(given.ids.begin(), given.ids.size());
  const Record record = given.type == RecordType::boot
                            ? boot_record(given.now_ns, given.boot, ids, replay.outputs())
                            : step_record(given.now_ns, given.event, ids, replay.outputs());
  const std::unique_ptr<std::uint8_t[]> room(new std::uint8_t[room_for(record)]);
  return crc32(Bytes(room.get(), encode_record(record, {room.get(), room_for(record)})), sum);
}

/// A sum for each recorded session, lived through in memory that held `fill`.
std::vector<std::uint32_t> sessions_in(std::uint8_t fill) {
  const FilledHeap heap(fill);
  std::vector<std::uint32_t> sums;
  for (const RecordedRobot& robot : recorded_robots()) {
    for (const RecordedSession& session : robot.sessions) {
      Replay replay(*robot.limits);
      std::uint32_t sum = 0;
      for (const RecordedStep& step : session) {
        fill_stack(fill);
        replay.feed(step.record());
        sum = sum_of(replay, step.record(), sum);
      }
      sums.push_back(sum);
    }
  }
  return sums;
}

}  // namespace

TEST_CASE(
    "recorded sessions, in memory of zeros and of ones: the same bytes put out and recorded") {
  const std::vector<std::uint32_t> zeros = sessions_in(0x00);
  CHECK(zeros.size() > 10);
  CHECK(zeros == sessions_in(0xFF));
}
