#include "process/verdict_text.hpp"

#include <array>
#include <cmath>
#include <cstdio>

namespace fairlead {
namespace {

template <class T>
std::string formatted(const char* format, T value) {
  std::array<char, 32> text{};
  const int size = std::snprintf(text.data(), text.size(), format, value);
  return std::string(text.data(), static_cast<std::size_t>(size));
}

// Told beside another one: all digits where six of both are the same.
std::string number(double value, double other) {
  if (std::isnan(value)) return "nan";  // not -nan
  const std::string text = formatted("%.6g", value);
  return value != other && text == formatted("%.6g", other) ? formatted("%.17g", value) : text;
}

std::string code_name(std::uint32_t code) { return formatted("G%03u", code); }

}  // namespace

std::string verdict_text(const Verdict& verdict) {
  const bool cut = verdict.outcome == static_cast<std::uint8_t>(Outcome::truncated);
  std::string text = "chunk " + std::to_string(verdict.seq) + " of " +
                     std::string(verdict.source.view()) + (cut ? " truncated: " : " refused: ") +
                     code_name(verdict.code);
  for (const std::string_view word : {verdict.part.view(), verdict.axis.view()}) {
    if (!word.empty()) text.append(" ").append(word);
  }
  if (verdict.row >= 0) text += ", row " + std::to_string(verdict.row);
  if (verdict.margin != 0.0) {
    text += ": " + number(verdict.value, verdict.limit) + ", limit " +
            number(verdict.limit, verdict.value);
  }
  if (!verdict.limit_source.empty()) {
    text.append(" (").append(verdict.limit_source.view()).append(")");
  }
  return text;
}

std::string verdict_line(Verdict verdict) {
  if (verdict.margin != 0.0) verdict.limit_source = {};
  return verdict_text(verdict);
}

}  // namespace fairlead
