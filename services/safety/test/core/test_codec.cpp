// The wire: golden bytes written by Python, and every way a frame can be wrong.

#include <doctest/doctest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <map>
#include <random>
#include <string>

#include "boundary.hpp"
#include "chunk_builder.hpp"
#include "core/wire/phrase.hpp"
#include "fairlead_safety/query_messages.hpp"

using namespace fairlead;
using namespace fairlead::test;

namespace {

using Frame = std::vector<std::uint8_t>;

std::filesystem::path golden_dir() {
  const char* from_environment = std::getenv("FAIRLEAD_GOLDEN_DIR");
  return from_environment != nullptr ? from_environment : FAIRLEAD_GOLDEN_DIR;
}

Frame read_file(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return Frame(std::istreambuf_iterator<char>(file), {});
}

template <class Message>
void check_same_bytes(const Frame& golden) {
  Message message;
  REQUIRE(decode(golden, message) == FrameFault::none);
  CHECK(frame_of(message) == golden);
}

const std::map<std::string, std::function<void(const Frame&)>> known_types{
    {"JointState", check_same_bytes<JointState>},
    {"HalStatus", check_same_bytes<HalStatus>},
    {"ActionChunk", check_same_bytes<ActionChunk>},
    {"SafeChunk", check_same_bytes<SafeChunk>},
    {"Lease", check_same_bytes<Lease>},
    {"Verdict", check_same_bytes<Verdict>},
    {"GateStatus", check_same_bytes<GateStatus>},
    {"StopLevel", check_same_bytes<StopLevel>},
    {"Heartbeat", check_same_bytes<Heartbeat>},
    {"Refusal", check_same_bytes<Refusal>},
    {"Done", check_same_bytes<Done>},
    {"StatusQuery", check_same_bytes<StatusQuery>},
    {"Arm", check_same_bytes<Arm>},
    {"ArmReply", check_same_bytes<ArmReply>},
    {"Disarm", check_same_bytes<Disarm>},
    {"Reset", check_same_bytes<Reset>},
    {"Claim", check_same_bytes<Claim>},
    {"ClaimReply", check_same_bytes<ClaimReply>},
    {"Release", check_same_bytes<Release>}};

Frame a_chunk() {
  return ChunkBuilder()
      .joint(arm, Mode::joint_position, arm_1, {0.1, 0.2})
      .scalar(gripper, Mode::gripper_position, {0.03, 0.03})
      .frame();
}

FrameFault fault_of(const Frame& frame) {
  ActionChunk chunk;
  return decode(frame, chunk);
}

FrameFault heartbeat_fault(const Frame& frame) {
  Heartbeat heartbeat;
  return decode(frame, heartbeat);
}

std::size_t fuzz_frames() {
  const char* wanted = std::getenv("FAIRLEAD_FUZZ_FRAMES");
  return wanted != nullptr ? std::strtoul(wanted, nullptr, 10) : 100'000;
}

// Reads every byte that a decoded chunk claims to have, so that a sanitizer sees an overrun.
double touch(const ActionChunk& chunk) {
  double sum = 0.0;
  for (const ActionPart& part : chunk.parts)
    for (std::size_t i = 0; i < part.values.size(); ++i) sum += part.values[i];
  return sum;
}

}  // namespace

TEST_CASE("golden frames decode and encode to the bytes Python wrote") {
  std::map<std::string, int> seen;
  for (const auto& entry : std::filesystem::directory_iterator(golden_dir())) {
    const std::string name = entry.path().filename().string();
    const auto type = known_types.find(name.substr(0, name.find('.')));
    if (entry.path().extension() != ".bin" || type == known_types.end()) continue;
    INFO(name);
    // Its frame_id of 256 bytes is well-formed, and longer than any identifier the gate takes.
    if (name == "ActionChunk.extremes.bin") {
      CHECK(fault_of(read_file(entry.path())) == FrameFault::capacity);
      continue;
    }
    type->second(read_file(entry.path()));
    ++seen[type->first];
  }
  CHECK(seen.size() == known_types.size());
}

TEST_CASE("a frame cut short at any byte is refused") {
  const Frame whole = a_chunk();
  REQUIRE(fault_of(whole) == FrameFault::none);
  for (std::size_t size = 0; size < whole.size(); ++size)
    CHECK(fault_of(Frame(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size))) ==
          FrameFault::cut_short);
}

TEST_CASE("a byte after the message is refused") {
  Frame frame = a_chunk();
  frame.push_back(0);
  CHECK(fault_of(frame) == FrameFault::trailing);
}

TEST_CASE("64 KiB is the most that is looked at") {
  CHECK(fault_of(Frame(max_frame_bytes + 1, 0x90)) == FrameFault::oversized);
  CHECK(fault_of(Frame(max_frame_bytes, 0x90)) != FrameFault::oversized);
}

TEST_CASE("another type, another version and another arity are named as such") {
  CHECK(heartbeat_fault({0x93, 13, 1, 5}) == FrameFault::none);
  CHECK(heartbeat_fault({0x93, 12, 1, 5}) == FrameFault::message);
  CHECK(heartbeat_fault({0x93, 13, 2, 5}) == FrameFault::version);
  CHECK(heartbeat_fault({0x94, 13, 2, 5, 5}) == FrameFault::version);
  CHECK(heartbeat_fault({0x94, 13, 1, 5, 5}) == FrameFault::arity);
  CHECK(heartbeat_fault({0x92, 13, 1}) == FrameFault::arity);
  CHECK(heartbeat_fault({0x91, 13}) == FrameFault::arity);
}

TEST_CASE("a field of another msgpack type is refused") {
  for (const std::uint8_t lead : Frame{0xA1, 0xC0, 0xC2, 0xC4, 0x90, 0x80, 0xFF, 0xD0, 0xCB, 0xC1})
    CHECK(heartbeat_fault({0x93, 13, 1, lead, 0, 0, 0, 0, 0, 0, 0, 0}) != FrameFault::none);
  CHECK(heartbeat_fault({0xC0}) == FrameFault::wrong_type);
}

TEST_CASE("lists and identifiers longer than the gate's room are refused, prose is cut") {
  Lease lease;
  Frame many_stops = frame_of(lease);
  REQUIRE(many_stops.back() == 0x90);  // an empty list of stops is the last field
  many_stops.back() = 0xDD;            // becomes one of 2^32 - 1 elements
  many_stops.insert(many_stops.end(), {0xFF, 0xFF, 0xFF, 0xFF});
  CHECK(decode(many_stops, lease) == FrameFault::capacity);

  const std::string long_name(65, 'a');
  Release release;
  Frame too_long{0x94, 29, 1, 0xD9, 65};
  too_long.insert(too_long.end(), long_name.begin(), long_name.end());
  too_long.push_back(1);
  CHECK(decode(too_long, release) == FrameFault::capacity);

  Frame prose{0x93, 23, 1, 0xDA, 0x01, 0x01};
  prose.insert(prose.end(), 257, 'b');
  Arm arming;
  CHECK(decode(prose, arming) == FrameFault::none);
  CHECK(arming.by.size() == 256);
}

TEST_CASE("control characters in a text are told by their bytes, in a name they are refused") {
  const auto by = [](std::string_view text) {
    Arm arming;
    arming.by = "?";
    Frame frame{0x93, 23, 1, static_cast<std::uint8_t>(0xA0U | text.size())};
    frame.insert(frame.end(), text.begin(), text.end());
    CHECK(decode(frame, arming) == FrameFault::none);
    return std::string(arming.by.view());
  };
  CHECK(by("a\nINFO b") == "a\\x0aINFO b");
  CHECK(by("\x1b[2J") == "\\x1b[2J");
  CHECK(by(std::string_view("\0", 1)) == "\\x00");
  CHECK(by("\x1f \x7f") == "\\x1f \\x7f");
  CHECK(by("\xC2\x85\xC2\xA0") == "\\xc2\\x85\xC2\xA0");
  CHECK(by("\xE2\x80\xAE!") == "\\xe2\\x80\\xae!");  // from right to left
  CHECK(by("\xE2\x81\xA6") == "\\xe2\\x81\\xa6");
  CHECK(by("\xE2\x80\x8F\xE2\x80\x90") == "\\xe2\\x80\\x8f\xE2\x80\x90");
  CHECK(by("\xE2\x80\x8E\xE2\x80\xAF") == "\\xe2\\x80\\x8e\xE2\x80\xAF");
  CHECK(by("\xE2\x80\xA8\xE2\x81\xA9") == "\\xe2\\x80\\xa8\\xe2\\x81\\xa9");
  CHECK(by("\xE2\x82\xAC") == "\xE2\x82\xAC");
  CHECK(has_control("\xC2"));  // a character that is cut off, which no decoded text has
  CHECK(by("\xC3\xA9\xE2\x80\xA7\xE2\x81\xA5\xE2\x81\xAA") ==
        "\xC3\xA9\xE2\x80\xA7\xE2\x81\xA5\xE2\x81\xAA");
  Frame named{0x94, 29, 1, 0xA3, 'a', '\n', 'b', 1};
  Release release;
  CHECK(decode(named, release) == FrameFault::text);
  named[5] = '-';
  CHECK(decode(named, release) == FrameFault::none);
}

TEST_CASE("text that is not UTF-8 is refused") {
  const auto by = [](std::initializer_list<std::uint8_t> text) {
    Frame frame{0x93, 23, 1, static_cast<std::uint8_t>(0xA0U | text.size())};
    frame.insert(frame.end(), text);
    Arm arming;
    return decode(frame, arming);
  };
  CHECK(by({'a', 0xC3, 0xA9}) == FrameFault::none);         // é
  CHECK(by({0xE2, 0x82, 0xAC}) == FrameFault::none);        // €
  CHECK(by({0xF0, 0x9F, 0xA4, 0x96}) == FrameFault::none);  // a robot
  CHECK(by({0xE0, 0xA0, 0x80}) == FrameFault::none);        // the first of three bytes
  CHECK(by({0xED, 0x9F, 0xBF}) == FrameFault::none);        // the last before the surrogates
  CHECK(by({0xF0, 0x90, 0x80, 0x80}) == FrameFault::none);  // the first of four bytes
  CHECK(by({0xF4, 0x8F, 0xBF, 0xBF}) == FrameFault::none);  // the last character
  CHECK(by({0x7F, 0xC2, 0x80, 0xDF, 0xBF}) == FrameFault::none);
  CHECK(by({0xC1, 0xBF}) == FrameFault::text);
  CHECK(by({0xF5, 0x80, 0x80, 0x80}) == FrameFault::text);
  CHECK(by({0xFF}) == FrameFault::text);
  CHECK(by({0x80}) == FrameFault::text);  // a continuation alone
  CHECK(by({0xC3}) == FrameFault::text);  // cut
  CHECK(by({0xC3, 0x41}) == FrameFault::text);
  CHECK(by({0xC0, 0xAF}) == FrameFault::text);              // overlong
  CHECK(by({0xE0, 0x80, 0xAF}) == FrameFault::text);        // overlong
  CHECK(by({0xF0, 0x80, 0x80, 0xAF}) == FrameFault::text);  // overlong
  CHECK(by({0xED, 0xA0, 0x80}) == FrameFault::text);        // a surrogate
  CHECK(by({0xF4, 0x90, 0x80, 0x80}) == FrameFault::text);  // beyond the last character
}

TEST_CASE("prose is never cut inside a character") {
  std::string text(255, 'a');
  text += "\xC3\xA9";
  CHECK(Text(text).size() == 255);
}

TEST_CASE("integers stand for numbers, since Python writes 20 for 20.0") {
  Claim claim;
  claim.chunk_rate_hz = 20.0;
  Frame frame = frame_of(claim);
  const Frame as_double{0xCB, 0x40, 0x34, 0, 0, 0, 0, 0, 0};
  auto place = std::search(frame.begin(), frame.end(), as_double.begin(), as_double.end());
  REQUIRE(place != frame.end());
  place = frame.erase(place, place + 9);
  frame.insert(place, 20);
  Claim read;
  REQUIRE(decode(frame, read) == FrameFault::none);
  CHECK(read.chunk_rate_hz == 20.0);
}

TEST_CASE("every signed number survives") {
  Verdict verdict;
  for (const std::int64_t row :
       {std::int64_t{0}, std::int64_t{-1}, std::int64_t{-32}, std::int64_t{-33}, std::int64_t{-128},
        std::int64_t{-129}, std::int64_t{-32768}, std::int64_t{-32769}, std::int64_t{INT32_MIN},
        std::int64_t{INT32_MIN} - 1, INT64_MIN, INT64_MAX, std::int64_t{127}, std::int64_t{128}}) {
    verdict.row = row;
    Verdict read;
    REQUIRE(decode(frame_of(verdict), read) == FrameFault::none);
    CHECK(read.row == row);
  }
}

TEST_CASE("every fault has a name") {
  for (std::uint8_t fault = 0; fault <= static_cast<std::uint8_t>(FrameFault::trailing); ++fault)
    CHECK(fault_name(static_cast<FrameFault>(fault)) != "unknown");
  const auto last = static_cast<std::uint8_t>(FrameFault::trailing);
  CHECK(fault_name(static_cast<FrameFault>(last + 1)) == "unknown");
  CHECK(fault_name(static_cast<FrameFault>(200)) == "unknown");
}

TEST_CASE("every mode has a name, a width and a checker or none") {
  CHECK(mode_name(5) == "cartesian_delta");
  CHECK(mode_name(13) == "unknown");
  CHECK(mode_width(0, 11) == 11);
  CHECK(mode_width(4, 11) == 7);
  CHECK(mode_width(7, 11) == 6);
  CHECK(mode_width(12, 11) == 1);
  CHECK(mode_width(3, 11) == 0);
  CHECK(mode_width(200, 11) == 0);
  CHECK_FALSE(is_joint_mode(200));
  std::size_t checkers = 0;
  for (int mode = 0; mode < 256; ++mode)
    checkers += mode_has_checker(static_cast<std::uint8_t>(mode)) ? 1U : 0U;
  CHECK(checkers == 10);
}

TEST_CASE("signed numbers beyond their range, and numbers of other widths") {
  Verdict verdict;
  verdict.row = 7;
  Frame frame = frame_of(verdict);
  const auto row = std::find(frame.begin(), frame.end(), 7);
  REQUIRE(row != frame.end());
  const auto with_row = [&](const Frame& encoded) {
    Frame changed(frame.begin(), row);
    changed.insert(changed.end(), encoded.begin(), encoded.end());
    changed.insert(changed.end(), row + 1, frame.end());
    Verdict read;
    const FrameFault fault = decode(changed, read);
    return fault == FrameFault::none ? read.row : std::int64_t{-999};
  };
  CHECK(with_row({0xD0, 0x80}) == -128);
  CHECK(with_row({0xD3, 0, 0, 0, 0, 0, 0, 0, 9}) == 9);
  CHECK(with_row({0xCF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF}) == -999);
  CHECK(with_row({0xC0}) == -999);

  Claim claim;
  claim.chunk_rate_hz = 0.5;
  Frame rate = frame_of(claim);
  const Frame as_double{0xCB, 0x3F, 0xE0, 0, 0, 0, 0, 0, 0};
  auto place = std::search(rate.begin(), rate.end(), as_double.begin(), as_double.end());
  REQUIRE(place != rate.end());
  place = rate.erase(place, place + 9);
  const Frame as_single{0xCA, 0x3F, 0, 0, 0};
  rate.insert(place, as_single.begin(), as_single.end());
  Claim read;
  REQUIRE(decode(rate, read) == FrameFault::none);
  CHECK(read.chunk_rate_hz == 0.5);
}

TEST_CASE("a buffer that is too small is reported, never overrun") {
  const Frame whole = a_chunk();
  ActionChunk chunk;
  REQUIRE(decode(whole, chunk) == FrameFault::none);
  for (std::size_t room = 0; room < whole.size(); ++room) {
    Frame buffer(room);
    CHECK(encode(chunk, buffer) == 0);
  }
}

TEST_CASE("random and bit-flipped frames are refused or decode to what they say") {
  std::mt19937_64 random(20261121);
  const Frame good = a_chunk();
  double sum = 0.0;
  std::size_t accepted = 0;
  for (std::size_t i = 0; i < fuzz_frames(); ++i) {
    Frame frame;
    if (i % 2 == 0) {
      frame.resize(random() % 300);
      for (std::uint8_t& byte : frame) byte = static_cast<std::uint8_t>(random());
    } else {
      frame = good;
      for (std::uint64_t flips = 1 + random() % 4; flips > 0; --flips)
        frame[random() % frame.size()] ^= static_cast<std::uint8_t>(1U << (random() % 8));
    }
    ActionChunk chunk;
    if (decode(frame, chunk) == FrameFault::none) {
      ++accepted;
      sum += std::isfinite(touch(chunk)) ? 1.0 : 0.0;
    }
    HalStatus status;
    JointState state;
    (void)decode(frame, status);
    (void)decode(frame, state);
  }
  CHECK(accepted > 0);  // flips inside a number are still well-formed
  CHECK(accepted < fuzz_frames());
}
