#include "decisions/log_words.hpp"

#include <algorithm>

#include "process/refusal.hpp"

namespace fairlead {
namespace {

bool is_one_of(const std::vector<std::string>& names, const std::string& word) {
  return std::find(names.begin(), names.end(), word) != names.end();
}

}  // namespace

LogWords parse_log_words(const std::string& command, const std::vector<std::string>& words,
                         const std::vector<std::string>& valued,
                         const std::vector<std::string>& flags) {
  const std::string see = "; see: fairlead-decisions " + command + " --help";
  LogWords found;
  found.help = is_one_of(words, "--help") || is_one_of(words, "-h");
  if (found.help) return found;
  for (std::size_t i = 0; i < words.size(); ++i) {
    const std::string& word = words[i];
    if (is_one_of(valued, word)) {
      // Empty is a variable that was not set: it would look like an option that was not given.
      if (++i == words.size() || words[i].empty())
        throw ConfigRefused(command + ": " + word + ": expected a value after it" + see);
      found.options[word] = words[i];
    } else if (is_one_of(flags, word)) {
      found.options[word] = "";
    } else if (found.log.empty() && !word.starts_with("-")) {
      found.log = word;
    } else {
      throw ConfigRefused(command + ": unknown argument '" + word + "'" + see);
    }
  }
  if (found.log.empty()) throw ConfigRefused(command + ": expected a decision log" + see);
  return found;
}

}  // namespace fairlead
