// Realtime: a part that holds in the tick that runs, and was measured to move when that began. By
// its end it may have stopped at once, or gone on all the while: the row behind it starts anywhere
// between.

#include <doctest/doctest.h>

#include "core/chunk/judgement.hpp"
#include "free_arm.hpp"

using namespace fairlead;
using namespace fairlead::test;
using namespace fairlead::test::free_arm;

namespace {

constexpr double eps = 1e-9;

// From 1 m/s it takes 0.1 m to brake, after a lag of 20 ms.
Limits sliding() {
  Limits limits = free_arm::limits();
  limits.joints[slide_x].acceleration_limit = 5.0;
  limits.joints[slide_x].stop_lag = 0.02;
  return limits;
}

MeasuredState moving(double speed) {
  MeasuredState state = at_rest();
  state.velocities[slide_x] = speed;
  return state;
}

Judgement held(const Limits& limits, Mode mode, double value, double measured,
               bool is_realtime = true) {
  PartMemories memories;
  memories[arm].kind = MovingMode::Kind::known;
  memories[arm].mode = static_cast<std::uint8_t>(mode);
  RowBefore before;
  before.measured = !is_realtime;
  before.memories = &memories;
  return free_arm::judge(limits, one_joint(mode, slide_x, {value}).chunk, moving(measured), before);
}

Limits bounded(double lower, double upper) {
  Limits limits = sliding();
  limits.joints[slide_x].bounds.lower = lower;
  limits.joints[slide_x].bounds.upper = upper;
  return limits;
}

// The tool is at x = 0.7 m.
Limits walled(double x) {
  Limits limits = sliding();
  (void)limits.workspace.volumes.push_back({"wall", true, {x, -1, 0}, {x + 1, 1, 1}});
  return limits;
}

}  // namespace

TEST_CASE("G024 realtime: what held may have gone on through the tick, and the row goes on there") {
  // 0.05 m held, 0.05 m told, 0.02 m of lag, 0.1 m of braking.
  constexpr auto speed = Mode::joint_velocity;
  CHECK(held(bounded(-2.0, 0.22 + eps), speed, 1.0, 1.0).evidence.ok());
  CHECK(held(bounded(-2.0, 0.22 - eps), speed, 1.0, 1.0).evidence.code == 24);
  CHECK(held(bounded(-0.22 - eps, 2.0), speed, -1.0, -1.0).evidence.ok());
  CHECK(held(bounded(-0.22 + eps, 2.0), speed, -1.0, -1.0).evidence.code == 24);
  // In lockstep the state was measured after the hold.
  CHECK(held(bounded(-2.0, 0.17 + eps), speed, 1.0, 1.0, false).evidence.ok());
  CHECK(held(bounded(-2.0, 0.17 - eps), speed, 1.0, 1.0, false).evidence.code == 24);
}

TEST_CASE("G024 realtime: what held may have stopped at once, and is the faster to its target") {
  // 0.04 m in the tick are 0.8 m/s, and 64 mm to brake; from 25 mm on it would be 9 mm.
  constexpr auto target = Mode::joint_position;
  CHECK(held(bounded(-2.0, 0.104 + eps), target, 0.04, 0.5).evidence.ok());
  CHECK(held(bounded(-2.0, 0.104 - eps), target, 0.04, 0.5).evidence.code == 24);
  CHECK(held(bounded(-0.104 - eps, 2.0), target, -0.04, -0.5).evidence.ok());
  CHECK(held(bounded(-0.104 + eps, 2.0), target, -0.04, -0.5).evidence.code == 24);
  // A target behind where it may have gone on to: back at 0.3 m/s, which takes 9 mm.
  CHECK(held(bounded(0.001 - eps, 2.0), target, 0.01, 0.5).evidence.ok());
  CHECK(held(bounded(0.001 + eps, 2.0), target, 0.01, 0.5).evidence.code == 24);
}

TEST_CASE("G031 realtime: what held is kept from a wall as far as it may have gone on") {
  constexpr auto speed = Mode::joint_velocity;
  CHECK(held(walled(0.92 + eps), speed, 1.0, 1.0).evidence.ok());
  CHECK(held(walled(0.92 - eps), speed, 1.0, 1.0).evidence.code == 31);
  CHECK(held(walled(0.87 - eps), speed, 1.0, 1.0, false).evidence.code == 31);
  CHECK(held(walled(0.87 + eps), speed, 1.0, 1.0, false).evidence.ok());
  // It may as well have stopped at once: then the row leads back from where it was measured.
  Limits behind = sliding();
  (void)behind.workspace.volumes.push_back({"wall", true, {-1, -1, 0}, {0.7 - 0.17 + eps, 1, 1}});
  CHECK(held(behind, speed, -1.0, 1.0).evidence.code == 31);
  // What rests, rests.
  CHECK(held(walled(0.87 + eps), speed, 1.0, 0.0).evidence.ok());
}

TEST_CASE("realtime: behind the first row a target is reached, whatever the hold left open") {
  PartMemories memories;
  memories[arm].kind = MovingMode::Kind::known;
  memories[arm].mode = static_cast<std::uint8_t>(Mode::joint_position);
  RowBefore before;
  before.measured = false;
  before.memories = &memories;
  const auto judged = [&](double x, const Row& targets) {
    Limits limits = walled(x);
    limits.joints[slide_x].acceleration_limit = 1e18;
    limits.joints[slide_x].stop_lag = 0.0;
    return free_arm::judge(limits, one_joint(Mode::joint_position, slide_x, targets).chunk,
                           moving(1.0), before)
        .evidence;
  };
  CHECK(judged(0.775 + eps, {0.05, 0.05}).ok());  // 25 mm of it in the first row
  CHECK(judged(0.775 - eps, {0.05, 0.05}).row == 0);
  CHECK(judged(0.775 + eps, {0.05, 0.075 - eps}).ok());
  CHECK(judged(0.775 + eps, {0.05, 0.075 + 3 * eps}).row == 1);
}

TEST_CASE("realtime: a part that a row moves in the tick that runs has not held") {
  ChunkBuilder acts = one_joint(Mode::joint_velocity, slide_x, {1.0});
  const RowBefore before{&acts.chunk, 0, false, nullptr};
  const auto judged = [&](double upper) {
    return free_arm::judge(bounded(-2.0, upper),
                           one_joint(Mode::joint_velocity, slide_x, {1.0}).chunk, moving(1.0),
                           before)
        .evidence.code;
  };
  CHECK(judged(0.22 + eps) == 0);  // told twice, and braking
  CHECK(judged(0.22 - eps) == 24);
}
