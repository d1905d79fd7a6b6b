// Recorded sessions with something changed: a message lost, told twice, spoiled or late, another
// part of another session put in its place. What nothing unjudged may ever do holds all the same.
//
//   FAIRLEAD_SEQUENCE_STEPS=400000   steps in all, drawn sessions and these

#include <cstdlib>
#include <random>

#include "decisions/replay.hpp"
#include "recorded_sessions.hpp"
#include "released_rows.hpp"

using namespace fairlead;
using namespace fairlead::test;

namespace {

std::size_t wanted_steps() {
  const char* wanted = std::getenv("FAIRLEAD_SEQUENCE_STEPS");
  return wanted != nullptr ? std::strtoul(wanted, nullptr, 10) : 16'000;
}

/// What was seen on all changed sessions.
struct Seen {
  std::size_t steps = 0, released = 0, refused = 0, armed = 0, changed = 0;
};

class ChangedDay {
 public:
  ChangedDay(const RecordedRobot& robot, std::uint64_t seed, Seen& seen)
      : robot_(robot), random_(seed), replay_(*robot.limits), seen_(seen) {
    jump(below(robot_.sessions.size()), 0);
  }

  void run(std::size_t steps) {
    for (std::size_t i = 0; i < steps; ++i) {
      if (at_ >= session().size()) jump(below(robot_.sessions.size()), 0);
      next();
    }
  }

 private:
  std::uint64_t below(std::uint64_t limit) { return random_() % limit; }
  [[nodiscard]] const RecordedSession& session() const { return robot_.sessions[session_]; }

  /// Go on from there; what is recorded happens at once, in the gate's own time.
  void jump(std::size_t to_session, std::size_t to_step) {
    session_ = to_session;
    at_ = to_step;
    const std::uint64_t then = session()[at_].record().now_ns;
    shift_ = now_ns_ - then;  // unsigned: wraps, and back when it is added
  }

  void next() {
    const Record& recorded = session()[at_++].record();
    switch (recorded.type == RecordType::boot ? 99 : below(100)) {
      case 0:
      case 1:  // lost
        ++seen_.changed;
        return;
      case 2:
      case 3:  // told twice
        feed(recorded);
        break;
      case 4:
      case 5:
        return spoiled(recorded);
      case 6:  // late
        shift_ += below(200) * 1'000'000;
        break;
      case 7:
        if (below(4) == 0) return splice();
        break;
      default:
        return feed(recorded);
    }
    ++seen_.changed;
    feed(recorded);
  }

  void splice() {
    ++seen_.changed;
    const std::size_t to_session = below(3) == 0 ? below(robot_.sessions.size()) : session_;
    jump(to_session, below(robot_.sessions[to_session].size()));
  }

  void spoiled(const Record& recorded) {
    payload_.assign(recorded.event.payload.begin(), recorded.event.payload.end());
    for (std::uint64_t changes = 1 + below(3); changes > 0 && !payload_.empty(); --changes) {
      const std::size_t at = below(payload_.size());
      if (below(8) == 0)
        payload_.resize(at);
      else
        payload_[at] ^= static_cast<std::uint8_t>(1U << below(8));
    }
    Record record = recorded;
    record.event.payload = payload_;
    ++seen_.changed;
    feed(record);
  }

  void feed(Record record) {
    record.now_ns = std::max(record.now_ns + shift_, now_ns_);
    record.event.received_ns = record.now_ns;
    now_ns_ = record.now_ns;
    if (record.type == RecordType::boot) farthest_ = FarthestMeasured();
    if (record.event.kind == EventKind::joint_state &&
        decode(record.event.payload, state_) == FrameFault::none)
      farthest_.note(*robot_.limits, state_);
    replay_.feed(record);
    ++seen_.steps;
    look_at_outputs();
  }

  void look_at_outputs() {
    const bool armed = replay_.state() == GateState::armed;
    seen_.armed += armed ? 1U : 0U;
    CHECK_FALSE(replay_.outputs().overflowed());
    for (const Output& output : replay_.outputs().items()) {
      const Bytes payload = replay_.outputs().payload(output);
      if (output.kind == OutputKind::reply && decode(payload, reply_) == FrameFault::none)
        epoch_ = reply_.epoch;
      if (output.kind == OutputKind::lease) {
        REQUIRE(decode(payload, lease_) == FrameFault::none);
        CHECK((armed || lease_.grants.empty()));
        CHECK((!armed || lease_.stop_ids.empty()));
      }
      if (output.kind == OutputKind::verdict) {
        REQUIRE(decode(payload, verdict_) == FrameFault::none);
        seen_.refused += verdict_.outcome == static_cast<std::uint8_t>(Outcome::refused) ? 1U : 0U;
      }
      if (output.kind == OutputKind::safe_chunk) look_at(payload, armed);
    }
  }

  void look_at(Bytes payload, bool armed) {
    REQUIRE(armed);
    REQUIRE(decode(payload, safe_) == FrameFault::none);
    CHECK(safe_.epoch == epoch_);
    CHECK(test::ReleasedRows(*robot_.limits, farthest_).within_limits(safe_));
    seen_.released += safe_.horizon;
  }

  const RecordedRobot& robot_;
  std::mt19937_64 random_;
  Replay replay_;
  Seen& seen_;
  std::size_t session_ = 0, at_ = 0;
  std::uint64_t now_ns_ = 0, shift_ = 0, epoch_ = 0;
  std::vector<std::uint8_t> payload_;
  FarthestMeasured farthest_;
  JointState state_;
  ArmReply reply_;
  Lease lease_;
  Verdict verdict_;
  SafeChunk safe_;
};

}  // namespace

TEST_CASE(
    "random changes of recorded sessions release nothing while not armed, nothing over a limit") {
  constexpr std::size_t each = 1000;
  const std::vector<RecordedRobot> robots = recorded_robots();
  std::size_t steps = 0, armed = 0, released = 0, refused = 0;
  for (const RecordedRobot& robot : robots) {
    Seen seen;
    std::uint64_t seed = 0;
    while (seen.steps < wanted_steps() / robots.size()) ChangedDay(robot, ++seed, seen).run(each);
    if (std::getenv("FAIRLEAD_SEQUENCE_STEPS") != nullptr)
      MESSAGE(robot.name, ": ", seen.steps, " steps, ", seen.changed, " changes, armed in ",
              seen.armed, ", ", seen.released, " rows released, ", seen.refused, " chunks refused");
    steps += seen.steps;
    armed += seen.armed;
    released += seen.released;
    refused += seen.refused;
  }
  CHECK(armed > steps / 20);
  CHECK(released > steps / 100);
  CHECK(refused > steps / 1000);
}
