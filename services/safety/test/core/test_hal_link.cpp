// Whose session the gate follows, by itself: a stray message shuts nobody out, a dead HAL's late
// message brings it not back, and a tick is a period.

#include <doctest/doctest.h>

#include <utility>
#include <vector>

#include "core/gate/hal_link.hpp"
#include "gate_rig.hpp"

using namespace fairlead;
using namespace fairlead::test;

namespace {

using News = HalLink::News;

constexpr std::uint64_t first = 0xA, second = 0xB, third = 0xC;

struct Robot {
  Limits limits = test_limits();
  HalLink link{limits};

  HalStatus status(std::uint64_t session) const {
    HalStatus status;
    status.session = session;
    status.robot_hash = hash_of(7);
    status.pacing = "realtime";
    status.period_ns = period_ns;
    status.state = "ready";
    for (const JointLimits& item : limits.joints) (void)status.joints.push_back(item.name);
    for (const PassiveLimits& item : limits.passive_joints)
      (void)status.passive_joints.push_back(item.name);
    return status;
  }
  News announce(std::uint64_t session) { return link.take_status(status(session)); }
  void state(std::uint64_t tick, std::uint64_t now_ns) { link.take_state(message(tick), now_ns); }
  JointState message(std::uint64_t tick) const {
    JointState message;
    message.session = link.session();
    message.tick = tick;
    message.positions = view(positions);
    message.velocities = view(velocities);
    message.efforts = view(efforts);
    (void)message.acted.push_back(Acted{});
    return message;
  }
  static NumberView view(const std::vector<double>& numbers) {
    return NumberView(Bytes(reinterpret_cast<const std::uint8_t*>(numbers.data()),
                            numbers.size() * sizeof(double)));
  }
  std::vector<double> positions{0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7};
  std::vector<double> velocities{1.1, 1.2, 1.3, 1.4, 1.5, 1.6, 1.7};
  std::vector<double> efforts{2.1, 2.2, 2.3, 2.4, 2.5, 2.6, 2.7};
};

}  // namespace

TEST_CASE("the first session that announces itself is followed; session 0 is none") {
  Robot robot;
  CHECK(robot.announce(0) == News::nothing);
  CHECK(robot.link.session() == 0);
  CHECK(robot.link.mismatch() == "no hal/status received yet");
  CHECK(robot.announce(first) == News::new_session);
  CHECK(robot.link.session() == first);
  CHECK(robot.link.mismatch().empty());
  CHECK(robot.announce(first) == News::nothing);
  CHECK_FALSE(robot.link.has_state());
  CHECK(robot.link.tick() == 0);
}

TEST_CASE("a state is copied whole, and heard") {
  Robot robot;
  robot.announce(first);
  robot.state(41, 3'000 * ms);
  CHECK(robot.link.has_state());
  CHECK(robot.link.tick() == 41);
  CHECK(robot.link.arrival_ns() == 3'000 * ms);
  CHECK(robot.link.heard_ns() == 3'000 * ms);
  const MeasuredState& state = robot.link.state();
  CHECK(state.count == 7);
  for (std::size_t i = 0; i < 7; ++i) {
    CHECK(state.positions[i] == robot.positions[i]);
    CHECK(state.velocities[i] == robot.velocities[i]);
    CHECK(state.efforts[i] == robot.efforts[i]);
  }
  CHECK(state.positions[7] == 0.0);  // nothing beyond the robot's joints
  robot.link.note_heard(3'010 * ms);
  CHECK(robot.link.heard_ns() == 3'010 * ms);
  CHECK(robot.link.arrival_ns() == 3'000 * ms);
}

TEST_CASE("a state is repeated in every number, in what acted and in its episode") {
  Robot robot;
  robot.announce(first);
  robot.state(41, 3'000 * ms);
  const JointState same = robot.message(41);
  CHECK(robot.link.repeats(same));
  for (auto* numbers : {&robot.positions, &robot.velocities, &robot.efforts}) {
    const double before = std::exchange(numbers->back(), 9.0);
    CHECK_FALSE(robot.link.repeats(robot.message(41)));
    numbers->back() = before;
  }
  JointState other = same;
  other.episode_tick = 1;
  CHECK_FALSE(robot.link.repeats(other));
  other = same;
  other.acted[0].row = 1;
  CHECK_FALSE(robot.link.repeats(other));
  other = same;
  other.acted[0].verdict_id = 1;
  CHECK_FALSE(robot.link.repeats(other));
}

TEST_CASE("another session is followed when it shows a state while the present one is silent") {
  Robot robot;
  robot.announce(first);
  robot.state(1, 1'000 * ms);
  CHECK(robot.announce(second) == News::nothing);
  CHECK(robot.link.rival() == second);
  CHECK(robot.link.session() == first);
  // 500 ms without a word are still one HAL that speaks; a nanosecond more is silence.
  CHECK(robot.link.take_rival_state(1'500 * ms) == News::two_at_once);
  CHECK(robot.link.take_rival_state(1'500 * ms + 1) == News::new_session);
  CHECK(robot.link.session() == second);
  CHECK(robot.link.rival() == 0);
  CHECK_FALSE(robot.link.has_state());
  CHECK_FALSE(robot.link.two_at_once(1'500 * ms + 1));
}

TEST_CASE("before its first state the present session has no say") {
  Robot robot;
  robot.announce(first);
  robot.announce(second);
  CHECK(robot.link.take_rival_state(10 * ms) == News::new_session);
  CHECK(robot.link.session() == second);
}

TEST_CASE("two that both deliver: told once, and over after two seconds without the other") {
  Robot robot;
  robot.announce(first);
  robot.state(1, 1'000 * ms);
  robot.announce(second);
  CHECK_FALSE(robot.link.two_at_once(1'000 * ms));
  CHECK_FALSE(robot.link.two_at_once(10 * ms));  // none was heard yet, at whatever time
  CHECK(robot.link.take_rival_state(1'100 * ms) == News::two_at_once);
  CHECK(robot.link.take_rival_state(1'200 * ms) == News::nothing);
  CHECK(robot.link.two_at_once(3'200 * ms));
  CHECK_FALSE(robot.link.two_at_once(3'200 * ms + 1));
}

TEST_CASE("a third one has to show its own state; the second's does not count for it") {
  Robot robot;
  robot.announce(first);
  robot.state(1, 1'000 * ms);
  robot.announce(second);
  CHECK(robot.link.take_rival_state(1'100 * ms) == News::two_at_once);
  CHECK(robot.announce(second) == News::nothing);
  CHECK(robot.link.two_at_once(1'200 * ms));  // its hal/status again changes nothing
  robot.announce(third);
  CHECK(robot.link.rival() == third);
  CHECK_FALSE(robot.link.two_at_once(1'200 * ms));
  CHECK(robot.link.take_rival_state(1'300 * ms) == News::two_at_once);
}

TEST_CASE("a session once left is never followed again") {
  Robot robot;
  robot.announce(first);
  robot.state(1, 1'000 * ms);
  robot.announce(second);
  CHECK(robot.link.take_rival_state(2'000 * ms) == News::new_session);
  CHECK(robot.announce(first) == News::nothing);
  CHECK(robot.link.rival() == 0);
  CHECK(robot.announce(third) == News::nothing);
  CHECK(robot.link.rival() == third);
}

TEST_CASE("the last 64 sessions that were left are remembered") {
  Robot robot;
  const auto follow = [&robot](std::uint64_t session) {
    robot.announce(session);
    CHECK(robot.link.take_rival_state(1'000 * ms) == News::new_session);
  };
  robot.announce(1000);
  for (std::uint64_t i = 1; i <= 64; ++i) follow(1000 + i);  // leaves 1000 to 1063
  CHECK(robot.announce(1000) == News::nothing);
  CHECK(robot.link.rival() == 0);
  CHECK(robot.announce(1063) == News::nothing);
  CHECK(robot.link.rival() == 0);
}

TEST_CASE("what a HAL says of itself may change, and is compared with the gate file") {
  Robot robot;
  robot.announce(first);
  HalStatus status = robot.status(first);
  status.state = "resetting";
  CHECK(robot.link.take_status(status) == News::nothing);
  CHECK(robot.link.resetting());
  status.pacing = "lockstep";
  CHECK(robot.link.take_status(status) == News::facts_changed);
  CHECK(robot.link.lockstep());
  CHECK(robot.link.take_status(status) == News::nothing);
  status.state = "fault";
  status.detail = "motor 3";
  CHECK(robot.link.take_status(status) == News::facts_changed);
  CHECK(robot.link.mismatch() == "the HAL reports a fault: motor 3");
}

TEST_CASE("joints are compared one by one, commanded and passive") {
  Robot robot;
  HalStatus status = robot.status(first);
  status.joints[5] = "other";
  robot.link.take_status(status);
  CHECK(robot.link.mismatch() == "the HAL's joint 5 is other, the gate file's gripper_joint");
  status = robot.status(first);
  status.passive_joints[0] = "mast";
  robot.link.take_status(status);
  CHECK(robot.link.mismatch() == "the HAL's passive joint 0 is mast, the gate file's torso");
  status = robot.status(first);
  status.passive_joints.clear();
  robot.link.take_status(status);
  CHECK(robot.link.mismatch() == "the HAL has 0 passive joint, the gate file 1");
}

TEST_CASE("the newest tick that can be: the periods begun since any of the last eight, and one") {
  Robot robot;
  robot.announce(first);
  CHECK(robot.link.newest_possible(50 * ms) == 0);
  robot.state(10, 1'000 * ms);
  CHECK(robot.link.newest_possible(1'000 * ms) == 11);
  CHECK(robot.link.newest_possible(1'000 * ms + 1) == 12);
  CHECK(robot.link.newest_possible(1'050 * ms) == 12);
  CHECK(robot.link.newest_possible(1'050 * ms + 1) == 13);
  robot.state(11, 1'200 * ms);  // late: the one before says more
  CHECK(robot.link.newest_possible(1'200 * ms) == 15);
  for (std::uint64_t i = 0; i < 7; ++i) robot.state(12 + i, (1'250 + 50 * i) * ms);
  CHECK(robot.link.newest_possible(1'550 * ms) == 19);  // the first is forgotten
}

TEST_CASE("ticks at the end of all ticks do not wrap") {
  Robot robot;
  robot.announce(first);
  robot.state(UINT64_MAX - 1, 1'000 * ms);
  CHECK(robot.link.newest_possible(9'000 * ms) == UINT64_MAX);
}

TEST_CASE("a leap is confirmed by a second state that follows from the first") {
  Robot robot;
  robot.announce(first);
  robot.state(10, 1'000 * ms);
  CHECK_FALSE(robot.link.confirms_leap(500, 1'050 * ms));
  CHECK(robot.link.confirms_leap(501, 1'100 * ms));
  CHECK_FALSE(robot.link.confirms_leap(502, 1'150 * ms));  // said and done: forgotten
  CHECK_FALSE(robot.link.confirms_leap(502, 1'200 * ms));  // the same tick again shows nothing
  CHECK_FALSE(robot.link.confirms_leap(504, 1'200 * ms));  // two in no time
  CHECK(robot.link.confirms_leap(505, 1'200 * ms));
}

TEST_CASE("a new session begins with no arrivals and no refused leap") {
  Robot robot;
  robot.announce(first);
  robot.state(1'000, 1'000 * ms);
  CHECK_FALSE(robot.link.confirms_leap(2'000, 1'000 * ms));
  robot.announce(second);
  CHECK(robot.link.take_rival_state(2'000 * ms) == News::new_session);
  CHECK(robot.link.newest_possible(2'000 * ms) == 0);
  CHECK_FALSE(robot.link.confirms_leap(2'001, 2'000 * ms));
  robot.state(5, 2'000 * ms);
  CHECK(robot.link.newest_possible(2'000 * ms) == 6);
}

TEST_CASE("every joint's positions tell how fast it went, the first one's too") {
  Robot robot;
  robot.announce(first);
  robot.state(1, 1'000 * ms);
  for (double& position : robot.positions) position += 0.015;
  robot.state(2, 1'050 * ms);
  for (std::size_t i = 0; i < measured_count; ++i) {
    CAPTURE(i);
    CHECK(robot.link.state().travel_speeds[i] == doctest::Approx(0.3).epsilon(1e-2));
  }
}

TEST_CASE("behind a lost state positions tell nothing any more once the world stands there") {
  for (const std::uint64_t lost : {0U, 1U, 5U}) {
    CAPTURE(lost);
    Robot robot;
    robot.announce(first);
    robot.state(1, 1'000 * ms);
    for (double& position : robot.positions) position += 0.015;
    robot.state(2 + lost, 1'050 * ms);
    const MeasuredState& state = robot.link.state();
    const double speed = state.travel_speeds[measured_count - 1];
    CHECK(speed == doctest::Approx(0.3).epsilon(1e-2));  // perhaps all in the last tick
    robot.link.note_repeat();
    for (std::size_t i = 0; i < measured_count; ++i)
      CHECK((state.travel_speeds[i] == 0.0) == (lost > 0));
  }
}
