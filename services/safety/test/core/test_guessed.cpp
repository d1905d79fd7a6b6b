// From beyond a limit, where a controller makes of a tool's motion what it likes: what is predicted
// to lead out need not. The free arm's tool is at (0.7, 0, 0.5).

#include <doctest/doctest.h>

#include "core/geometry/distances.hpp"
#include "free_arm.hpp"

using namespace fairlead;
using namespace fairlead::test;
using namespace fairlead::test::free_arm;

namespace {

Limits guessed(Gain gain) {
  Limits limits = free_arm::limits();
  limits.parts[arm].modes.cartesian_delta.gain = gain;
  limits.parts[arm].modes.joint_velocity.gain = gain;
  return limits;
}

Limits with_volume(Gain gain, bool keep_out, std::array<double, 3> lower,
                   std::array<double, 3> upper) {
  Limits limits = guessed(gain);
  (void)limits.workspace.volumes.push_back({"shelf", keep_out, lower, upper});
  return limits;
}

std::uint32_t code_of(const Limits& limits, double along_x) {
  return free_arm::judge(limits,
                         ChunkBuilder().along(arm, Mode::cartesian_delta, 0, {along_x}).chunk)
      .evidence.code;
}

std::uint32_t slid(const Limits& limits, double speed) {
  return free_arm::judge(limits, one_joint(Mode::joint_velocity, slide_x, {speed}).chunk)
      .evidence.code;
}

constexpr Gain known{1.0, 1.0}, some{0.5, 1.0};

}  // namespace

TEST_CASE("a broken limit may be left as it is, or has to get better, or excuses nothing") {
  const auto at = [](double margin, double before, Excuse excuse) {
    return is_breach(margin, [before] { return before; }, excuse);
  };
  for (const Excuse excuse : {Excuse::none, Excuse::better, Excuse::as_it_is}) {
    CHECK_FALSE(at(0.0, -1.0, excuse));
    CHECK(at(-0.1, 0.1, excuse));
    CHECK(at(-0.1, -0.05, excuse));
    CHECK(at(-0.1, -0.2, excuse) == (excuse == Excuse::none));
    CHECK(at(-0.1, -0.1, excuse) == (excuse != Excuse::as_it_is));
    CHECK(at(not_a_number, -0.1, excuse));
    CHECK(at(-0.1, not_a_number, excuse));
  }
  CHECK_FALSE(at(-0.1 + 2e-6, -0.1, Excuse::better));
  CHECK(at(-0.1 + 0.5e-6, -0.1, Excuse::better));
}

TEST_CASE("G031 outside, a motion of which not all may happen has to lead nearer") {
  for (const bool keep_out : {false, true}) {
    const auto at = [&](Gain gain) {
      return keep_out ? with_volume(gain, true, {0.65, -1, 0}, {2, 1, 1})
                      : with_volume(gain, false, {-1, -1, 0}, {0.65, 1, 1});
    };
    CHECK(code_of(at(known), 0.0) == 0);
    CHECK(code_of(at(some), 0.0) == 31);
    CHECK(code_of(at(some), 0.01) == 31);
    CHECK(code_of(at(some), -0.01) == 0);
    CHECK(code_of(at(known), -0.01) == 0);
    CHECK(slid(at(some), 0.0) == 0);  // a joint's own velocity is no guess
  }
}

TEST_CASE("G032 capsules too near each other: nothing of which not all may happen leads out") {
  for (const Gain gain : {known, some}) {
    Limits limits = guessed(gain);
    limits.collision.capsules[0] = {0, {1.0, 0, 0.5}, {1.0, 0, 0.5}, 0.05};
    limits.collision.capsules[1] = {tool_link, {0, 0, 0}, {0, 0, 0}, 0.05};
    limits.collision.clearance = 0.25;  // 0.2 m between them
    CHECK(code_of(limits, -0.01) == (gain.lower < 1.0 ? 32 : 0));
    CHECK(code_of(limits, 0.0) == (gain.lower < 1.0 ? 32 : 0));
    CHECK(code_of(limits, 0.01) == 32);
    CHECK(slid(limits, -0.1) == 0);
  }
}
