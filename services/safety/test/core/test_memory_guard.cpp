// G050: bytes that must not change are read a slice at a time.

#include "core/monitor/memory_guard.hpp"

#include <doctest/doctest.h>

#include <memory>
#include <vector>

#include "core/monitor/self_monitor.hpp"
#include "test_robot.hpp"

using namespace fairlead;

namespace {

constexpr std::uint64_t ms = 1'000'000;

// How many slices a pass over so many bytes takes, one every 4 ms.
int slices_of(std::size_t size) {
  const std::vector<std::uint8_t> bytes(size, 7);
  MemoryGuard guard{Bytes(bytes)};
  std::uint64_t now_ns = 1000 * ms;
  for (int read = 1;; ++read, now_ns += 4 * ms)
    if (guard.read_on(now_ns)) return read;
}

}  // namespace

TEST_CASE("G050 a pass takes at most 200 slices, of as many bytes each as it takes") {
  CHECK(slices_of(1) == 1);
  CHECK(slices_of(200) == 200);
  CHECK(slices_of(201) == 101);
  CHECK(slices_of(399) == 200);
  CHECK(slices_of(400) == 200);
  CHECK(slices_of(401) == 134);
  CHECK(slices_of(600) == 200);
}

TEST_CASE("G050 a slice is read 4 ms after the last at the earliest") {
  const std::vector<std::uint8_t> bytes(2, 7);
  MemoryGuard guard{Bytes(bytes)};
  CHECK_FALSE(guard.read_on(1000 * ms));
  CHECK_FALSE(guard.read_on(1004 * ms - 1));
  CHECK(guard.read_on(1004 * ms));
  CHECK_FALSE(guard.read_on(1004 * ms));
  CHECK_FALSE(guard.read_on(1007 * ms));
  CHECK_FALSE(guard.read_on(1008 * ms));
  CHECK(guard.read_on(1012 * ms));
}

TEST_CASE("G050 a pass of a claim's own limits has ended when all of them are read, not before") {
  const Limits limits = test::test_limits();
  const auto model = std::make_unique<RobotModel>(limits);
  SelfMonitor monitor(limits, *model);
  const auto claims = std::make_unique<ClaimTable>();
  const std::vector<std::uint8_t> bytes(2, 7);  // two slices; the limits have two hundred
  LiveClaim& claim = *claims->free_place();
  claim.guard = MemoryGuard{Bytes(bytes)};
  for (const bool live : {true, false}) {
    claim.id = live ? 1 : 0;
    std::uint64_t now_ns = live ? 1000 * ms : 2000 * ms;
    CHECK_FALSE(monitor.read_on(now_ns, *claims));
    CHECK(monitor.read_on(now_ns + 4 * ms, *claims) == live);
    CHECK_FALSE(monitor.read_on(now_ns + 8 * ms, *claims));
  }
}
