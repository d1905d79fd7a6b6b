// A claim's own limit for joints of different limits, and tightened more than once.
#include <doctest/doctest.h>

#include "boundary.hpp"
#include "core/gate/admission.hpp"
#include "test_robot.hpp"

using namespace fairlead;
using namespace fairlead::test;

namespace {

bool allowed(const Limits& limits, ModeLimits& modes, double value) {
  const LimitOverride wanted{"arm", static_cast<std::uint8_t>(Mode::joint_velocity),
                             "velocity_limit", value};
  return tighten(limits, arm, wanted, modes).empty();
}

}  // namespace

TEST_CASE("a claim's own limit is not above that of its slowest joint, whichever that is") {
  for (const auto& [slow, quick] : {std::pair{arm_1, arm_2}, std::pair{arm_2, arm_1}}) {
    Limits limits = test_limits();
    limits.joints[slow].velocity_limit = 1.0;
    limits.joints[quick].velocity_limit = 2.0;
    ModeLimits modes = limits.parts[arm].modes;
    CHECK_FALSE(allowed(limits, modes, just_above(1.0)));
    CHECK(allowed(limits, modes, 1.0));
    CHECK(modes.joint_velocity.claimed_limit == 1.0);
  }
}

TEST_CASE("a limit that was tightened may be tightened further, and not loosened again") {
  const Limits limits = test_limits();
  ModeLimits modes = limits.parts[arm].modes;
  CHECK(allowed(limits, modes, 0.5));
  CHECK_FALSE(allowed(limits, modes, just_above(0.5)));
  CHECK(modes.joint_velocity.claimed_limit == 0.5);
  CHECK(allowed(limits, modes, 0.25));
  CHECK(modes.joint_velocity.claimed_limit == 0.25);
}
