#include "process/verdict_text.hpp"

#include "core/chunk/judgement.hpp"

namespace fairlead {

bool has_magnitude(const Verdict& verdict) {
  return !verdict.unit.empty() || verdict.margin != 0.0;
}

std::string verdict_text(const Verdict& verdict) {
  Evidence evidence;
  evidence.code = verdict.code;
  evidence.row = verdict.row;
  evidence.part = verdict.part.view();
  evidence.axis = verdict.axis.view();
  evidence.value = verdict.value;
  evidence.limit = verdict.limit;
  evidence.margin = verdict.margin;
  if (has_magnitude(verdict)) evidence.unit = verdict.unit.empty() ? "1" : verdict.unit.view();
  evidence.limit_source = verdict.limit_source.view();
  const bool cut = verdict.outcome == static_cast<std::uint8_t>(Outcome::truncated);
  return "chunk " + std::to_string(verdict.seq) + " of " + std::string(verdict.source.view()) +
         (cut ? " truncated: " : " refused: ") + std::string(words_of(evidence).view());
}

}  // namespace fairlead
