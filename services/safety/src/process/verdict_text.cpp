#include "process/verdict_text.hpp"

#include "core/chunk/words_of.hpp"

namespace fairlead {

std::string verdict_text(const Verdict& verdict) {
  Evidence evidence;
  evidence.code = verdict.code;
  evidence.row = verdict.row;
  evidence.part = verdict.part.view();
  evidence.axis = verdict.axis.view();
  evidence.value = verdict.value;
  evidence.limit = verdict.limit;
  evidence.margin = verdict.margin;
  evidence.unit = verdict.unit.view();
  evidence.limit_source = verdict.limit_source.view();
  const bool cut = verdict.outcome == static_cast<std::uint8_t>(Outcome::truncated);
  return "chunk " + std::to_string(verdict.seq) + " of " + std::string(verdict.source.view()) +
         (cut ? " truncated: " : " refused: ") + std::string(words_of(evidence).view());
}

}  // namespace fairlead
