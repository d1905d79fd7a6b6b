#include "core/chunk/words_of.hpp"

namespace fairlead {
namespace {

// With a blank before it; a plain number has none.
Text unit_after(std::string_view unit) {
  return unit.empty() || unit == "1" ? Text() : phrase(" ", unit);
}

}  // namespace

Text words_of(const Evidence& evidence) {
  Text text = code_name(evidence.code);
  for (const std::string_view word : {evidence.part, evidence.axis})
    if (!word.empty()) text = phrase(text, " ", word);
  if (evidence.row >= 0) text = phrase(text, ", row ", evidence.row);
  if (!evidence.has_magnitude())
    return evidence.limit_source.empty() ? text : phrase(text, ": needs ", evidence.limit_source);
  const Text unit = unit_after(evidence.unit);
  text = phrase(text, ": ", Beside{evidence.value, evidence.limit}, unit, ", limit ",
                Beside{evidence.limit, evidence.value}, unit);
  return evidence.key.empty() ? text : phrase(text, " (", evidence.key, ")");
}

}  // namespace fairlead
