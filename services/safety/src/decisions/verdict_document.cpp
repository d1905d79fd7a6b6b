#include "decisions/verdict_document.hpp"

#include <array>
#include <cmath>
#include <cstdio>

namespace fairlead {
namespace {

using nlohmann::json;

// JSON has no NaN and no infinity: they are written as words.
json number(double value) {
  if (std::isfinite(value)) return value;
  if (std::isnan(value)) return "nan";
  return value > 0.0 ? "inf" : "-inf";
}

}  // namespace

std::string outcome_name(std::uint8_t outcome) {
  switch (static_cast<Outcome>(outcome)) {
    case Outcome::released:
      return "released";
    case Outcome::truncated:
      return "truncated";
    case Outcome::refused:
      return "refused";
  }
  return "unknown";
}

std::string hex_id(std::uint64_t id) {
  if (id == 0) return "none";
  std::array<char, 17> text{};
  std::snprintf(text.data(), text.size(), "%016llx", static_cast<unsigned long long>(id));
  return text.data();
}

json verdict_document(const Verdict& verdict) {
  json document = {{"verdict_id", hex_id(verdict.verdict_id)},
                   {"claim_id", hex_id(verdict.claim_id)},
                   {"source", verdict.source.view()},
                   {"seq", verdict.seq},
                   {"outcome", outcome_name(verdict.outcome)},
                   {"code", verdict.code},
                   {"row", verdict.row},
                   {"part", verdict.part.view()},
                   {"axis", verdict.axis.view()},
                   {"value", number(verdict.value)},
                   {"limit", number(verdict.limit)},
                   {"margin", number(verdict.margin)},
                   {"unit", verdict.unit.view()},
                   {"limit_source", verdict.limit_source.view()},
                   {"released_first", verdict.released_first},
                   {"released_last", verdict.released_last}};
  return document;
}

}  // namespace fairlead
