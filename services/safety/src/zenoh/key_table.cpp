#include "zenoh/key_table.hpp"

#include <algorithm>

#include "process/refusal.hpp"

namespace fairlead {
namespace {

bool is_letter_or_digit(char c) { return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9'); }

void check(std::string_view who, std::string_view name) {
  if (!is_key_chunk(name)) {
    throw ConfigRefused(
        std::string(who) +
        ": expected 1 to 64 of a-z 0-9 _ . - starting with a letter or digit, got '" +
        std::string(name) + "'");
  }
}

}  // namespace

bool is_key_chunk(std::string_view name) {
  return !name.empty() && name.size() <= 64 && is_letter_or_digit(name.front()) &&
         std::all_of(name.begin(), name.end(), [](char c) {
           return is_letter_or_digit(c) || c == '_' || c == '.' || c == '-';
         });
}

KeyTable::KeyTable(std::string_view name_space, std::string_view robot) {
  check("robot id", robot);
  check("namespace", name_space);
  prefix_ = std::string(name_space) + "/" + std::string(robot) + "/";
}

std::string KeyTable::key(std::string_view rest) const { return prefix_ + std::string(rest); }

std::string KeyTable::key(std::string_view group, std::string_view last) const {
  return prefix_ + std::string(group) + "/" + std::string(last);
}

}  // namespace fairlead
