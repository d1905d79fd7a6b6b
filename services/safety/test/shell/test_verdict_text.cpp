#include <doctest/doctest.h>

#include <limits>

#include "process/verdict_text.hpp"

using namespace fairlead;

TEST_CASE("a truncated chunk's line carries code, place, numbers and source") {
  Verdict verdict;
  verdict.outcome = static_cast<std::uint8_t>(Outcome::truncated);
  verdict.source = "runner";
  verdict.seq = 7;
  verdict.code = 20;
  verdict.row = 5;
  verdict.part = "arm";
  verdict.axis = "linear";
  verdict.value = 0.09;
  verdict.limit = 0.0867;
  verdict.margin = verdict.limit - verdict.value;
  verdict.limit_source = "OSC_POSE";
  CHECK(verdict_text(verdict) ==
        "chunk 7 of runner truncated: G020 arm linear, row 5: 0.09, limit 0.0867 (OSC_POSE)");
  CHECK(verdict_line(verdict) ==
        "chunk 7 of runner truncated: G020 arm linear, row 5: 0.09, limit 0.0867");
}

TEST_CASE("a refusal without numbers says what was expected") {
  Verdict verdict;
  verdict.outcome = static_cast<std::uint8_t>(Outcome::refused);
  verdict.source = "runner";
  verdict.seq = 1;
  verdict.code = 3;
  verdict.axis = "epoch";
  verdict.limit_source = "the current arm epoch";
  CHECK(verdict_text(verdict) == "chunk 1 of runner refused: G003 epoch (the current arm epoch)");
}

TEST_CASE("what is no number has no sign") {
  Verdict verdict;
  verdict.outcome = static_cast<std::uint8_t>(Outcome::refused);
  verdict.source = "runner";
  verdict.seq = 2;
  verdict.code = 8;
  verdict.value = -std::numeric_limits<double>::quiet_NaN();
  verdict.limit = 1e6;
  verdict.margin = verdict.limit - verdict.value;
  CHECK(verdict_text(verdict) == "chunk 2 of runner refused: G008: nan, limit 1e+06");
}
