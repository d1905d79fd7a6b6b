// Whoever asks on a key of their own asks in their own name.
#include <doctest/doctest.h>

#include <string>
#include <string_view>

#include "../core/gate_rig.hpp"
#include "process/foreign_name.hpp"

using namespace fairlead;
using namespace fairlead::test;

namespace {

template <class Message>
std::string said(EventKind kind, std::string_view on_key_of, const Message& message) {
  const std::vector<std::uint8_t> frame = frame_of(message);
  Event event;
  event.kind = kind;
  event.source = on_key_of;
  event.payload = frame;
  return foreign_name(event);
}

}  // namespace

TEST_CASE("a command on a person's key is that person's, whatever host and program") {
  for (const char* by : {"ada@gpu (fairlead)", "ada (a program)", "ada"}) {
    CHECK(said(EventKind::arm, "ada", Arm{by}).empty());
    CHECK(said(EventKind::disarm, "ada", Disarm{by}).empty());
    CHECK(said(EventKind::reset, "ada", Reset{by, 1}).empty());
    const std::string foreign = "asked in the name of ada on the key of ben";
    CHECK(said(EventKind::arm, "ben", Arm{by}) == foreign);
    CHECK(said(EventKind::disarm, "ben", Disarm{by}) == foreign);
    CHECK(said(EventKind::reset, "ben", Reset{by, 1}) == foreign);
  }
}

TEST_CASE("part of a name, or none, is another's") {
  for (const char* by : {"", "@gpu", "ad@gpu", "adam@gpu", "ADA"})
    CHECK_FALSE(said(EventKind::reset, "ada", Reset{by, 1}).empty());
}

TEST_CASE("a command on the key that is nobody's may be anybody's") {
  CHECK(said(EventKind::arm, "", Arm{"ada@gpu"}).empty());
  CHECK(said(EventKind::disarm, "", Disarm{""}).empty());
  CHECK(said(EventKind::reset, "", Reset{"ben", 1}).empty());
}

TEST_CASE("a claim on a person's key is of its source, and of that person") {
  Claim claim;
  claim.source = "teleop";
  CHECK(said(EventKind::claim, "teleop", claim).empty());
  CHECK(said(EventKind::claim, "teleop/ada", claim) == "asked in the name of  on the key of ada");
  claim.by = "ada@gpu (fairlead)";
  CHECK(said(EventKind::claim, "teleop", claim).empty());
  CHECK(said(EventKind::claim, "teleop/ada", claim).empty());
  CHECK(said(EventKind::claim, "teleop/ben", claim) ==
        "asked in the name of ada on the key of ben");
  CHECK(said(EventKind::claim, "runner/ada", claim) ==
        "asked in the name of teleop on the key of runner");
}

TEST_CASE("claims and releases are their sources', and frames that do not decode the core's") {
  Release release;
  release.source = "planner";
  CHECK(said(EventKind::release, "planner", release).empty());
  CHECK(said(EventKind::release, "", release) == "asked in the name of planner on the key of ");
  CHECK(said(EventKind::reset, "ada", Arm{"ben"}).empty());
}
