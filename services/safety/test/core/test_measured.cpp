// Checks of the measured state, by themselves: what is missing, not finite, or jumps.

#include <doctest/doctest.h>

#include <numbers>
#include <vector>

#include "boundary.hpp"
#include "chunk_builder.hpp"
#include "core/chunk/state_check.hpp"

using namespace fairlead;
using namespace fairlead::test;

namespace {

struct Message {
  std::vector<double> positions = std::vector<double>(measured_count, 0.0);
  std::vector<double> velocities = std::vector<double>(measured_count, 0.0);
  std::vector<double> efforts = std::vector<double>(measured_count, 0.0);
  std::size_t parts = 4;

  Evidence check() const {
    JointState state;
    state.positions = view(positions);
    state.velocities = view(velocities);
    state.efforts = view(efforts);
    for (std::size_t i = 0; i < parts; ++i) (void)state.acted.push_back(Acted{});
    return check_state(test_limits(), state);
  }
  static NumberView view(const std::vector<double>& numbers) {
    return NumberView(Bytes(reinterpret_cast<const std::uint8_t*>(numbers.data()),
                            numbers.size() * sizeof(double)));
  }
};

MeasuredState state_at(std::uint64_t tick, std::size_t joint, double position) {
  MeasuredState state;
  state.tick = tick;
  state.count = measured_count;
  state.positions[joint] = position;
  return state;
}

Evidence jump(std::size_t joint, double from, double to, std::uint64_t ticks = 1) {
  return check_jump(test_limits(), state_at(100, joint, from), state_at(100 + ticks, joint, to));
}

}  // namespace

TEST_CASE("G011 a whole state passes and raises nothing") {
  const Evidence evidence = Message{}.check();
  CHECK(evidence.ok());
  CHECK_FALSE(evidence.raises_stop);
}

TEST_CASE("G011 every number of every block has to be finite: a stop that names the joint") {
  const char* names[] = {"base_x", "base_y",        "base_yaw", "arm_1",
                         "arm_2",  "gripper_joint", "torso"};
  for (std::size_t i = 0; i < measured_count; ++i)
    for (const double bad : {not_a_number, infinite, -infinite})
      for (auto block : {&Message::positions, &Message::velocities, &Message::efforts}) {
        Message message;
        (message.*block)[i] = bad;
        const Evidence evidence = message.check();
        CHECK(evidence.code == 11);
        CHECK(evidence.axis == names[i]);
        CHECK(evidence.raises_stop);
      }
}

TEST_CASE("G011 blocks of another length, or a part without its act, are stops") {
  for (const std::size_t count : {std::size_t{0}, measured_count - 1, measured_count + 1}) {
    Message message;
    message.efforts.resize(count);
    const Evidence evidence = message.check();
    CHECK(evidence.code == 11);
    CHECK(evidence.axis == "efforts");
    CHECK(evidence.value == static_cast<double>(count));
    CHECK(evidence.limit == 7.0);
    CHECK(evidence.raises_stop);
  }
  for (const std::size_t parts : {std::size_t{3}, std::size_t{5}}) {
    Message message;
    message.parts = parts;
    const Evidence evidence = message.check();
    CHECK(evidence.code == 11);
    CHECK(evidence.axis == "acted");
    CHECK(evidence.raises_stop);
  }
}

TEST_CASE("G013 a joint moves at most its jump limit a tick, either way") {
  CHECK(jump(arm_1, 0.25, 0.75).ok());
  CHECK(jump(arm_1, 0.75, 0.25).ok());
  const Evidence evidence = jump(arm_1, 0.25, just_above(0.75));
  CHECK(evidence.code == 13);
  CHECK(evidence.axis == "arm_1");
  CHECK(evidence.limit == 0.5);
  CHECK(evidence.raises_stop);
  CHECK_FALSE(jump(arm_1, -0.25, 0.375).ok());
  CHECK(jump(arm_1, -0.25, 0.25).ok());
  CHECK(jump(arm_1, 0.0, 1.5, 3).ok());
  CHECK_FALSE(jump(arm_1, 0.0, 1.5, 2).ok());
}

TEST_CASE("G013 a passive joint has its own limit and its own source") {
  CHECK(jump(torso, 0.0, 0.02).ok());
  const Evidence evidence = jump(torso, 0.0, just_above(0.02));
  CHECK(evidence.code == 13);
  CHECK(evidence.axis == "torso");
  CHECK(evidence.limit_source == "test passive joint");
  CHECK(evidence.raises_stop);
  CHECK(jump(gripper_joint, 0.0, 0.25).ok());  // the commanded joint right before it
}

TEST_CASE("G013 only a continuous joint may be reported in another turn") {
  constexpr double turn = 2.0 * std::numbers::pi;
  CHECK(jump(base_yaw, 3.0, 3.25 - turn).ok());
  CHECK(jump(base_yaw, -3.0, -3.25 + turn).ok());
  CHECK_FALSE(jump(base_yaw, 3.0, 3.75 - turn).ok());
  CHECK_FALSE(jump(base_yaw, 0.0, turn / 4.0).ok());
  CHECK_FALSE(jump(arm_1, 3.0, 3.25 - turn).ok());
  CHECK_FALSE(jump(torso, 0.0, turn).ok());
  CHECK_FALSE(jump(base_x, 0.0, turn).ok());
}

TEST_CASE("a robot stands still where each measured joint does, the passive one too") {
  const Limits limits = test_limits();
  CHECK(at_standstill(limits, state_at_rest()));
  for (std::size_t i = 0; i < measured_count; ++i)
    for (const double sign : {1.0, -1.0}) {
      const double limit = i == torso ? 0.01 : 0.05;
      MeasuredState state = state_at_rest();
      state.velocities[i] = sign * just_below(limit);
      CHECK(at_standstill(limits, state));
      state.velocities[i] = sign * limit;
      CHECK_FALSE(at_standstill(limits, state));
    }
  MeasuredState none = state_at_rest();
  none.count = 0;
  CHECK_FALSE(at_standstill(limits, none));
}

TEST_CASE("a robot whose positions move does not stand still, whatever its velocities say") {
  const Limits limits = test_limits();
  for (std::size_t i = 0; i < measured_count; ++i) {
    const double noise = i == torso ? 0.0 : limits.joints[i].encoder_step / 0.05;
    const double limit = (i == torso ? 0.01 : 0.05) + noise;
    MeasuredState state = state_at_rest();
    state.travel_speeds[i] = limit - 1e-12;
    CHECK(at_standstill(limits, state));
    for (const double speed : {limit + 1e-12, -limit - 1e-12}) {
      state.travel_speeds[i] = speed;
      CHECK_FALSE(at_standstill(limits, state));
    }
  }
}

TEST_CASE("positions tell the speed of the last tick, in any turn") {
  const Limits limits = test_limits();
  CHECK(travel_speed(limits, arm_1, 0.5, 0.6) == doctest::Approx(0.1 / 0.05));
  CHECK(travel_speed(limits, arm_1, 0.6, 0.5) == doctest::Approx(-0.1 / 0.05));
  CHECK(travel_speed(limits, base_yaw, 3.1, 3.1 - 2.0 * std::numbers::pi) == doctest::Approx(0.0));
  CHECK(travel_speed(limits, torso, 0.0, 0.015) == doctest::Approx(0.3));
  // After lost states all of the way counts as the last tick's, up to what G013 takes in one tick.
  const double jump = limits.joints[arm_1].jump_limit;
  CHECK(travel_speed(limits, arm_1, 0.0, 1.5 * jump) == doctest::Approx(jump / 0.05));
  CHECK(travel_speed(limits, arm_1, 1.5 * jump, 0.0) == doctest::Approx(-jump / 0.05));
}

TEST_CASE("what an encoder's step may be is no motion, but may be one") {
  Limits limits = test_limits();
  JointLimits& joint = limits.joints[arm_1];
  joint.encoder_step = 0.001;  // 0.02 rad/s
  MeasuredState state = state_at_rest();
  for (const double side : {1.0, -1.0}) {
    const double standing = joint.standstill_velocity + 0.019, moving = standing + 0.002;
    state.travel_speeds[arm_1] = side * standing;
    CHECK(at_standstill(limits, state));
    CHECK(measured_speed(limits, state, arm_1) == 0.0);
    CHECK(possible_speed(state, arm_1) == standing);
    state.travel_speeds[arm_1] = side * moving;
    CHECK_FALSE(at_standstill(limits, state));
    CHECK(measured_speed(limits, state, arm_1) == side * moving);
  }
  state.velocities[arm_1] = -1.0;
  CHECK(possible_speed(state, arm_1) == 1.0);
}

TEST_CASE("G013 the unit of a passive joint is that of the link it moves") {
  Limits limits = test_limits();
  MeasuredState now = state_at_rest();
  ++now.tick;
  now.positions[torso] += 1.0;
  const auto unit = [&] { return check_jump(limits, state_at_rest(), now).unit; };
  CHECK(unit() == "m");
  for (Link& link : limits.kinematics.links)
    if (link.joint == torso) link.motion = LinkMotion::turn;
  CHECK(unit() == "rad");
  for (Link& link : limits.kinematics.links)
    if (link.joint == torso) link.joint = arm_1;
  CHECK(unit() == "1");  // it moves none
}
