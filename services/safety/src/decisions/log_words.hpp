// The arguments of a command that reads a decision log: which log, and its options.
#pragma once

#include <map>
#include <string>
#include <vector>

namespace fairlead {

struct LogWords {
  std::string log;
  bool help = false;
  std::map<std::string, std::string> options;  // by name; a flag's value is ""

  [[nodiscard]] bool has(const std::string& name) const { return options.contains(name); }
  /// The option's value, "" if it was not given.
  [[nodiscard]] std::string value(const std::string& name) const {
    const auto found = options.find(name);
    return found == options.end() ? "" : found->second;
  }
};

/// `COMMAND LOG [options]`: `valued` options take the next word, `flags` none.
/// Throws ConfigRefused for anything else, naming the command; nothing is asked of `--help`.
LogWords parse_log_words(const std::string& command, const std::vector<std::string>& words,
                         const std::vector<std::string>& valued,
                         const std::vector<std::string>& flags);

}  // namespace fairlead
