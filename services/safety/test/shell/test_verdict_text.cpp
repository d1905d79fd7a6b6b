#include "process/verdict_text.hpp"

#include <doctest/doctest.h>

#include <limits>
#include <string>

#include "core/chunk/judgement.hpp"

using namespace fairlead;

namespace {

Verdict refusal(std::uint32_t code) {
  Verdict verdict;
  verdict.outcome = static_cast<std::uint8_t>(Outcome::refused);
  verdict.source = "runner";
  verdict.seq = 1;
  verdict.code = code;
  return verdict;
}

}  // namespace

TEST_CASE("a truncated chunk's line carries code, place and numbers, not where the limit is from") {
  Verdict verdict = refusal(20);
  verdict.outcome = static_cast<std::uint8_t>(Outcome::truncated);
  verdict.row = 5;
  verdict.part = "arm";
  verdict.axis = "linear";
  verdict.value = 0.09;
  verdict.limit = 0.0867;
  verdict.margin = verdict.limit - verdict.value;
  verdict.unit = "m";
  verdict.limit_source = "OSC_POSE";
  CHECK(verdict_text(verdict) ==
        "chunk 1 of runner truncated: G020 arm linear, row 5: 0.09 m, limit 0.0867 m");
}

TEST_CASE("numbers that six digits do not tell apart have all of theirs, plain ones no unit") {
  Verdict verdict = refusal(33);
  verdict.value = 0.05;
  verdict.limit = 0.05 + 1e-12;
  verdict.margin = verdict.value - verdict.limit;
  verdict.unit = "1";
  CHECK(verdict_text(verdict) == "chunk 1 of runner refused: G033: 0.05, limit 0.050000000001");
}

TEST_CASE("a refusal by a rule says what it needs, never its numbers") {
  Verdict verdict = refusal(25);
  verdict.part = "arm";
  verdict.axis = "mode";
  verdict.row = 0;
  verdict.value = 5.0;  // numbers of modes
  verdict.limit = 1.0;
  verdict.limit_source = "standstill after a held tick";
  CHECK(verdict_text(verdict) ==
        "chunk 1 of runner refused: G025 arm mode, row 0: needs standstill after a held tick");
  verdict.limit_source = {};
  CHECK(verdict_text(verdict) == "chunk 1 of runner refused: G025 arm mode, row 0");
}

TEST_CASE(
    "a verdict of an older gate has no unit: its margin says whether its numbers mean anything") {
  Verdict verdict = refusal(20);
  verdict.axis = "linear";
  verdict.value = 0.5;
  verdict.limit = 0.25;
  verdict.margin = -0.25;
  verdict.limit_source = "OSC_POSE";
  CHECK(has_magnitude(verdict));
  CHECK(verdict_text(verdict) == "chunk 1 of runner refused: G020 linear: 0.5, limit 0.25");
  verdict.margin = 0.0;
  CHECK_FALSE(has_magnitude(verdict));
  CHECK(verdict_text(verdict) == "chunk 1 of runner refused: G020 linear: needs OSC_POSE");
}

TEST_CASE("what is no number has no sign") {
  Verdict verdict = refusal(8);
  verdict.value = -std::numeric_limits<double>::quiet_NaN();
  verdict.limit = 1e6;
  verdict.margin = verdict.limit - verdict.value;
  verdict.unit = "1";
  CHECK(verdict_text(verdict) == "chunk 1 of runner refused: G008: nan, limit 1e+06");
}

TEST_CASE("the longest rule and the longest place fit in 160 characters") {
  Verdict verdict = refusal(26);
  verdict.outcome = static_cast<std::uint8_t>(Outcome::truncated);
  verdict.seq = 4'294'967'295;
  verdict.row = 63;
  verdict.part = "left_gripper";
  verdict.axis = "right_middle_joint1";
  verdict.limit_source = Text(std::string_view(std::string(Rule::longest, 'r')));
  CHECK(verdict_text(verdict).size() <= 160);
}
