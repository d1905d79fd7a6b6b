// Sessions on which an independent reference said the same as the gate (tests/differential):
// through today's core the same bytes in give the same bytes out, at the limits of every check.
//
// `python -m bench.recorded_sessions.judged` records them anew, if both agree.
#include <doctest/doctest.h>

#include <string>
#include <vector>

#include "decisions/header.hpp"
#include "decisions/log_reader.hpp"
#include "decisions/replay.hpp"

using namespace fairlead;

namespace {

void check_sessions(const std::string& name) {
  CAPTURE(name);
  LogReader log(std::string(FAIRLEAD_SESSIONS_DIR) + "/judged_" + name + ".decisions");
  const std::unique_ptr<Limits> limits = recorded_limits(read_header(log.header()));
  Replay replay(*limits);
  std::size_t session = 0, step = 0;
  for (Record record; log.next(record); ++step) {
    if (record.type == RecordType::end) continue;
    if (record.type == RecordType::boot) ++session;
    CAPTURE(session);
    CAPTURE(step);
    replay.feed(record);
    REQUIRE(replay.same_as(record));
  }
  CHECK(session >= 5);
  CHECK(log.end() == LogEnd::complete);
}

}  // namespace

#define FAIRLEAD_JUDGED_SESSIONS(name) \
  TEST_CASE("sessions judged alike by the reference: " name) { check_sessions(name); }

FAIRLEAD_JUDGED_SESSIONS("panda_1")
FAIRLEAD_JUDGED_SESSIONS("panda_2")
FAIRLEAD_JUDGED_SESSIONS("panda_3")
FAIRLEAD_JUDGED_SESSIONS("panda_mobile_1")
FAIRLEAD_JUDGED_SESSIONS("panda_mobile_2")
FAIRLEAD_JUDGED_SESSIONS("panda_mobile_3")
FAIRLEAD_JUDGED_SESSIONS("panda_mobile_4")
FAIRLEAD_JUDGED_SESSIONS("panda_mobile_5")
FAIRLEAD_JUDGED_SESSIONS("dual_panda_1")
FAIRLEAD_JUDGED_SESSIONS("dual_panda_2")
FAIRLEAD_JUDGED_SESSIONS("dual_panda_3")
FAIRLEAD_JUDGED_SESSIONS("dual_panda_4")

TEST_CASE("a log whose verdicts in full are not those that were given is not judged alike") {
  LogReader log(std::string(FAIRLEAD_SESSIONS_DIR) + "/judged_panda_1.decisions");
  const std::unique_ptr<Limits> limits = recorded_limits(read_header(log.header()));
  Replay replay(*limits);
  std::size_t changed = 0;
  for (Record record; log.next(record) && changed < 10;) {
    if (record.type == RecordType::end) continue;
    replay.feed(record);
    if (record.outputs.empty()) continue;
    RecordedOutput& shown = record.outputs[0];
    std::vector<std::uint8_t> payload(shown.payload.begin(), shown.payload.end());
    payload.back() ^= 1U;
    const RecordedOutput given = shown;
    shown.payload = Bytes(payload);
    CHECK_FALSE(replay.same_as(record));
    shown = given;
    CHECK(replay.same_as(record));
    shown.source = "somebody";
    CHECK_FALSE(replay.same_as(record));
    ++changed;
  }
  CHECK(changed == 10);
}
