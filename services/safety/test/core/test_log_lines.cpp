// What the gate writes into its log when nobody asks.

#include <string>
#include <vector>

#include "gate_rig.hpp"

using namespace fairlead;
using namespace fairlead::test;

namespace {

std::vector<std::string> lines(const GateRig& rig) {
  std::vector<std::string> found;
  for (const Output& output : rig.out->items()) {
    if (output.kind != OutputKind::log) continue;
    const Bytes text = rig.out->payload(output);
    found.emplace_back(reinterpret_cast<const char*>(text.data()), text.size());
  }
  return found;
}

}  // namespace

TEST_CASE("a HAL that is followed is said, once") {
  GateRig rig;
  rig.send_hal_status();
  CHECK(lines(rig) == std::vector<std::string>{"following HAL session 000000000000abcd"});
  rig.send_hal_status();
  CHECK(lines(rig).empty());
}

TEST_CASE("what keeps a HAL from being armed is said") {
  GateRig rig;
  HalStatus status = rig.hal_status();
  status.period_ns = 1;
  rig.send(EventKind::hal_status, status);
  CHECK(lines(rig) ==
        std::vector<std::string>{"following HAL session 000000000000abcd",
                                 "the HAL's period is 1 ns, the gate file's 50000000 ns"});
}

TEST_CASE("two HALs at once are said by their sessions") {
  GateRig rig;
  rig.send_hal_status();
  rig.send_state();
  rig.send_hal_status(2);
  rig.session = 2;
  rig.next_tick();
  CHECK(lines(rig) == std::vector<std::string>{"two HALs publish for this robot: sessions "
                                               "000000000000abcd and 0000000000000002"});
  CHECK(rig.status().cause ==
        "two HALs publish for this robot: sessions 000000000000abcd and "
        "0000000000000002");
}

TEST_CASE("news of the HAL go out at once: to it and to whoever looks on") {
  GateRig rig;
  rig.send_hal_status();
  rig.send_state();
  rig.send_state();
  CHECK(rig.count(OutputKind::status) == 0);
  HalStatus status = rig.hal_status();
  status.period_ns = 1;
  rig.send(EventKind::hal_status, status);
  CHECK(rig.count(OutputKind::status) == 1);
  CHECK(rig.count(OutputKind::lease) == 1);
  rig.send(EventKind::hal_status, status);
  CHECK(rig.count(OutputKind::status) == 0);
  CHECK(rig.count(OutputKind::lease) == 0);
}

TEST_CASE("G050 a step that took too long is said with its length and how many there were") {
  GateRig rig;
  rig.limits.protocol.step_deadline_us = 2000;
  rig.restart(BootInfo{true, false, {}});
  rig.ready();
  const auto late = [&rig] {
    Event event;
    event.previous_step_ns = 2'500'000;
    rig.gate->step(rig.now_ns, event, *rig.out);
  };
  late();
  CHECK(lines(rig) ==
        std::vector<std::string>{"G050 step: 2500 us, limit 2000 us (step_deadline_us, "
                                 "three times in 60 s): 1 so far"});
  late();
  CHECK(lines(rig)[0].ends_with(": 2 so far"));
}

TEST_CASE("G011 the first joint, where it is a gripper's, is said to be outside and back") {
  GateRig rig;
  PartLimits& part = rig.limits.parts[base];
  part.modes = ModeLimits{};
  part.modes.gripper_binary = binary_mode();
  rig.limits.joints[base_x].bounded = true;
  rig.limits.joints[base_x].bounds = {-0.5, 0.5, 0.0};
  rig.restart(BootInfo{true, false, {}});
  rig.send_hal_status();
  rig.send_state();
  rig.positions[base_x] = 0.75;
  rig.next_tick();
  CHECK(lines(rig) ==
        std::vector<std::string>{"G011 gripper joint base_x is outside its limits: 0.75"});
  rig.next_tick();
  CHECK(lines(rig).empty());
  rig.positions[base_x] = 0.25;
  rig.next_tick();
  CHECK(lines(rig) ==
        std::vector<std::string>{"G011 gripper joint base_x is back inside its limits: 0.25"});
}
