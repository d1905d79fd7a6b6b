// Generated frames and chunks: the corpus is the golden frames, the rest follows from a seed.
//
//   FAIRLEAD_FUZZ_SECONDS=120   go on for so long (default: a fixed number of rounds)
//   FAIRLEAD_FUZZ_SEED=7        another stream

#include <doctest/doctest.h>

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <set>
#include <string>

#include "fairlead_safety/query_messages.hpp"
#include "row_judge.hpp"

using namespace fairlead;
using namespace fairlead::test;

namespace {

using Frame = std::vector<std::uint8_t>;

std::uint64_t from_environment(const char* name, std::uint64_t otherwise) {
  const char* text = std::getenv(name);
  return text == nullptr ? otherwise : std::strtoull(text, nullptr, 10);
}

/// Says when to stop, and counts.
class Rounds {
 public:
  explicit Rounds(std::size_t fixed)
      : fixed_(fixed), seconds_(from_environment("FAIRLEAD_FUZZ_SECONDS", 0)) {}
  bool next() {
    ++done_;
    if (seconds_ == 0) return done_ <= fixed_;
    return std::chrono::steady_clock::now() - begun_ < std::chrono::seconds(seconds_);
  }
  [[nodiscard]] std::size_t done() const { return done_ - 1; }

 private:
  std::size_t fixed_;
  std::uint64_t seconds_;
  std::size_t done_ = 0;
  std::chrono::steady_clock::time_point begun_ = std::chrono::steady_clock::now();
};

class Generator {
 public:
  explicit Generator(std::uint64_t stream)
      : random_(from_environment("FAIRLEAD_FUZZ_SEED", 20261121) + stream) {}
  std::uint64_t below(std::uint64_t limit) { return random_() % limit; }
  std::uint8_t byte() { return static_cast<std::uint8_t>(random_()); }

  /// A frame with one to four changes that a decoder may trip over.
  Frame spoil(const Frame& good, const Frame& other) {
    Frame frame = good;
    for (std::uint64_t changes = 1 + below(4); changes > 0 && !frame.empty(); --changes)
      change(frame, other);
    return frame;
  }

  /// A number near a limit, far from it, or none at all.
  double number(double limit) {
    switch (below(12)) {
      case 0:
        return limit;
      case 1:
        return -limit;
      case 2:
        return just_above(limit);
      case 3:
        return just_below(-limit);
      case 4:
        return below(30) == 0 ? not_a_number : 0.0;
      case 5:
        return below(30) == 0 ? infinite : 1e-300;
      case 6:
        return below(30) == 0 ? 1e7 : -0.0;
      default:
        return limit * (static_cast<double>(below(2001)) / 1000.0 - 1.0);
    }
  }

 private:
  void change(Frame& frame, const Frame& other) {
    constexpr std::array<std::uint8_t, 18> leads{0x80, 0x90, 0x9F, 0xA0, 0xBF, 0xC0,
                                                 0xC2, 0xC4, 0xC5, 0xC6, 0xCB, 0xCC,
                                                 0xCF, 0xD3, 0xDB, 0xDC, 0xDD, 0xFF};
    const auto at = static_cast<std::ptrdiff_t>(below(frame.size()));
    std::uint8_t& here = frame[static_cast<std::size_t>(at)];
    switch (below(7)) {
      case 0:
        here ^= static_cast<std::uint8_t>(1U << below(8));
        return;
      case 1:
        here = leads[below(leads.size())];
        return;
      case 2:
        frame.erase(frame.begin() + at);
        return;
      case 3:
        frame.insert(frame.begin() + at, byte());
        return;
      case 4:
        frame.resize(static_cast<std::size_t>(at));
        return;
      case 5:  // the end of another message
        frame.resize(static_cast<std::size_t>(at));
        if (frame.size() < other.size()) frame.insert(frame.end(), other.begin() + at, other.end());
        return;
      default:
        here = static_cast<std::uint8_t>(here + 1);
    }
  }

  std::mt19937_64 random_;
};

std::vector<Frame> golden_frames() {
  const char* folder = std::getenv("FAIRLEAD_GOLDEN_DIR");
  std::set<std::filesystem::path> paths;
  for (const auto& entry :
       std::filesystem::directory_iterator(folder != nullptr ? folder : FAIRLEAD_GOLDEN_DIR))
    if (entry.path().extension() == ".bin" && entry.file_size() <= 4096) paths.insert(entry.path());
  std::vector<Frame> frames;
  for (const std::filesystem::path& path : paths) {
    std::ifstream file(path, std::ios::binary);
    frames.emplace_back(std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>());
  }
  return frames;
}

// What decodes is what it says: written and read again it is the same message.
template <class Message>
bool survives(const Frame& frame, std::set<FrameFault>& faults) {
  Message message, again;
  const FrameFault fault = decode(frame, message);
  faults.insert(fault);
  if (fault != FrameFault::none) return false;
  const Frame written = frame_of(message);
  CHECK(decode(written, again) == FrameFault::none);
  CHECK(frame_of(again) == written);
  return true;
}

template <class... Messages>
std::size_t survive(const Frame& frame, std::set<FrameFault>& faults) {
  return (std::size_t{0} + ... + (survives<Messages>(frame, faults) ? 1U : 0U));
}

struct Command {
  std::uint8_t part;
  Mode mode;
  std::size_t width;
  double limit;  // about where its numbers become too big
};
constexpr std::array<Command, 10> commands{{{arm, Mode::joint_position, joint_count, 2.0},
                                            {arm, Mode::joint_velocity, joint_count, 1.5},
                                            {arm, Mode::cartesian_pose, 7, 1.0},
                                            {arm, Mode::cartesian_delta, 6, 0.1},
                                            {arm, Mode::cartesian_twist, 6, 0.5},
                                            {gripper, Mode::gripper_position, 1, 0.08},
                                            {gripper, Mode::gripper_binary, 1, 1.0},
                                            {base, Mode::joint_velocity, joint_count, 1.5},
                                            {base, Mode::body_twist, 6, 1.0},
                                            {composite, Mode::composite_mode, 1, 1.0}}};

void add_command(Generator& generator, ChunkBuilder& builder, std::size_t rows) {
  const Command& command = commands[generator.below(commands.size())];
  const bool joints = command.width == joint_count;
  const std::size_t moved = command.part == arm ? arm_1 : base_x;
  Rows numbers;
  for (std::size_t row = 0; row < rows; ++row) {
    Row values(command.width, 0.0);
    for (std::size_t i = 0; i < command.width; ++i)
      if (!joints || i == moved || generator.below(400) == 0)
        values[i] = generator.number(command.limit) * (generator.below(3) == 0 ? 1.0 : 0.2);
    if (command.mode == Mode::gripper_binary) values[0] = generator.below(40) == 0 ? 0.5 : 1.0;
    if (command.mode == Mode::cartesian_pose && generator.below(10) != 0)
      values = {0.7, 0.01 * values[1], 0.5, 0.0, 0.0, 0.0, 1.0};
    if (command.mode == Mode::body_twist && generator.below(20) != 0)
      values[2] = values[3] = values[4] = 0.0;
    numbers.push_back(values);
  }
  const bool plain = joints || command.width == 1;
  builder.add(command.part, command.mode, numbers, {}, plain ? "" : "base_link");
  if (joints)
    (void)builder.chunk.parts[builder.chunk.parts.size() - 1].active.push_back(
        static_cast<std::uint8_t>(moved));
}

double norm(const ActionPart& part, std::size_t first) {
  return std::sqrt(part.values[first] * part.values[first] +
                   part.values[first + 1] * part.values[first + 1] +
                   part.values[first + 2] * part.values[first + 2]);
}

// The absolute limits of the test robot once more, by hand.
bool within_limits(const ActionPart& part, std::size_t row, const MeasuredState& state) {
  constexpr double slack = 1e-12;
  const auto all_at_most = [&](double limit) {
    for (std::size_t i = 0; i < joint_count; ++i)
      if (!(std::abs(part.values[row * joint_count + i]) <= limit)) return false;
    return true;
  };
  const auto norms = [&](double linear, double angular) {
    return norm(part, row * 6) <= linear + slack && norm(part, row * 6 + 3) <= angular + slack;
  };
  switch (static_cast<Mode>(part.mode)) {
    case Mode::joint_position:
      return all_at_most(std::max(2.0, state.positions[arm_1]));  // outside: on its way back
    case Mode::joint_velocity:
      return all_at_most(1.5);
    case Mode::cartesian_pose:
      return std::abs(part.values[row * 7]) <= 1.0 && std::abs(part.values[row * 7 + 1]) <= 1.0 &&
             std::abs(part.values[row * 7 + 2]) <= 1.0;
    case Mode::cartesian_delta:
      return norms(0.1, 0.5);
    case Mode::cartesian_twist:
      return norms(0.5, 1.0);
    case Mode::body_twist:
      return norms(1.0, 1.5);
    case Mode::gripper_position:
      return part.values[row] >= 0.0 && part.values[row] <= 0.08;
    case Mode::gripper_binary:
      return part.values[row] == 0.0 || part.values[row] == 1.0;
    case Mode::composite_mode:
      return part.values[row] >= -1.0 && part.values[row] <= 1.0;
    default:
      return false;
  }
}

}  // namespace

TEST_CASE("fuzz: a spoiled frame is refused, or is a message that survives its own writing") {
  const std::vector<Frame> corpus = golden_frames();
  REQUIRE(corpus.size() > 30);
  Generator generator(1);
  Rounds rounds(4000);
  std::set<FrameFault> faults;
  std::size_t accepted = 0;
  while (rounds.next()) {
    const Frame frame = generator.spoil(corpus[generator.below(corpus.size())],
                                        corpus[generator.below(corpus.size())]);
    accepted += survive<JointState, HalStatus, ActionChunk, SafeChunk, Lease, Verdict, GateStatus,
                        StopLevel, Heartbeat, Refusal, Done, StatusQuery, Arm, ArmReply, Disarm,
                        Reset, Claim, ClaimReply, Release, LatchRecord>(frame, faults);
  }
  if (from_environment("FAIRLEAD_FUZZ_SECONDS", 0) > 0)
    MESSAGE(rounds.done() << " frames, " << accepted << " decoded, " << faults.size()
                          << " of 10 faults seen");
  CHECK(accepted > rounds.done() / 50);
  CHECK(faults.size() >= 8);  // all but: more than 64 KiB, and text or capacity by luck
}

TEST_CASE("fuzz: no row of any mode is released beyond a limit worked out by hand") {
  const Limits limits = test_limits();
  const ClaimLimits claim = whole_robot(limits);
  Generator generator(2);
  Rounds rounds(20'000);
  std::set<std::uint32_t> codes;
  std::size_t released = 0;
  while (rounds.next()) {
    const std::size_t rows = 1 + generator.below(6);
    ChunkBuilder builder;
    for (std::uint64_t parts = 1 + generator.below(2); parts > 0; --parts)
      add_command(generator, builder, rows);
    if (generator.below(50) == 0) builder.chunk.horizon += 1;
    MeasuredState state = state_at_rest();
    if (generator.below(20) == 0) state.positions[arm_1] = 2.2;
    const Evidence shape = check_shape(limits, claim, builder.chunk);
    codes.insert(shape.code);
    if (!shape.ok()) continue;
    const Judgement judgement = judge_rows(limits, claim, state, builder.chunk, 0, {});
    codes.insert(judgement.evidence.code);
    CHECK((judgement.outcome == Outcome::refused) == (judgement.row_count == 0));
    CHECK((judgement.outcome == Outcome::released) == judgement.evidence.ok());
    for (std::size_t row = 0; row < judgement.row_count; ++row)
      for (const ActionPart& part : builder.chunk.parts) CHECK(within_limits(part, row, state));
    released += judgement.row_count;
  }
  if (from_environment("FAIRLEAD_FUZZ_SECONDS", 0) > 0)
    MESSAGE(rounds.done() << " chunks, " << released << " rows released");
  // G030: two joints do not reach most poses.
  CHECK(codes == std::set<std::uint32_t>{0, 7, 8, 9, 11, 20, 21, 22, 30});
  CHECK(released > rounds.done() / 10);
}
