// Sessions recorded from real runs of the real gate, through today's core: the same bytes in, the
// same bytes out. A change that alters one decision of them is seen here, whatever it meant to
// change.
#include <algorithm>
#include <set>

#include "decisions/replay.hpp"
#include "fairlead_safety/messages.hpp"
#include "recorded_sessions.hpp"

using namespace fairlead;
using namespace fairlead::test;

namespace {

/// What today's core says, beside what was recorded, for whoever reads a failure.
std::string differences(const Replay& replay, const Record& record) {
  std::string text = std::to_string(replay.outputs().items().size()) + " outputs, recorded " +
                     std::to_string(record.output_count);
  const auto verdict_of = [](Bytes payload) {
    Verdict verdict;
    return decode(payload, verdict) == FrameFault::none
               ? "outcome " + std::to_string(verdict.outcome) + " code " +
                     std::to_string(verdict.code) + " row " + std::to_string(verdict.row)
               : std::string("no verdict");
  };
  for (const RecordedOutput& output : record.outputs)
    if (output.kind == OutputKind::verdict) text += "; recorded " + verdict_of(output.payload);
  for (const Output& output : replay.outputs().items())
    if (output.kind == OutputKind::verdict)
      text += "; now " + verdict_of(replay.outputs().payload(output));
  return text;
}

std::size_t steps_that_agree(const RecordedRobot& robot, std::size_t session) {
  Replay replay(*robot.limits);
  std::size_t agreed = 0;
  for (const RecordedStep& step : robot.sessions[session]) {
    replay.feed(step.record());
    if (!replay.same_as(step.record())) {
      FAIL_CHECK(robot.name, " session ", session + 1, " (line of ", robot.name,
                 ".sessions), step ", agreed, " of kind ",
                 static_cast<int>(step.record().event.kind), ": ",
                 differences(replay, step.record()));
      break;
    }
    ++agreed;
  }
  return agreed;
}

void note_verdicts(const RecordedSession& session, std::set<std::uint8_t>& outcomes,
                   std::set<std::uint32_t>& codes) {
  Verdict verdict;
  for (const RecordedStep& step : session)
    for (const RecordedOutput& output : step.record().outputs)
      if (output.kind == OutputKind::verdict &&
          decode(output.payload, verdict) == FrameFault::none) {
        outcomes.insert(verdict.outcome);
        codes.insert(verdict.code);
      }
}

}  // namespace

TEST_CASE("sessions recorded from real runs: the core answers each step as the real gate did") {
  for (const RecordedRobot& robot : recorded_robots()) {
    for (std::size_t session = 0; session < robot.sessions.size(); ++session)
      CHECK(steps_that_agree(robot, session) == robot.sessions[session].size());
  }
}

TEST_CASE(
    "sessions recorded from real runs show nearly every kind of event, each outcome, many rules") {
  std::set<EventKind> kinds;
  std::set<std::uint8_t> outcomes;
  std::set<std::uint32_t> codes;
  for (const RecordedRobot& robot : recorded_robots())
    for (const RecordedSession& session : robot.sessions) {
      for (const RecordedStep& step : session) kinds.insert(step.record().event.kind);
      note_verdicts(session, outcomes, codes);
    }
  CHECK(kinds.size() >= 12);  // of 13: all but the lease of another gate
  CHECK(outcomes == std::set<std::uint8_t>{0, 1, 2});
  CHECK(codes.size() >= 8);  // 0 and seven rules
}
