#include "decisions/log_choice.hpp"

#include "decisions/log_file.hpp"
#include "process/refusal.hpp"

namespace fairlead {

std::filesystem::path choose_log(const std::string& path) {
  if (!std::filesystem::is_directory(path)) return path;
  const auto logs = decision_logs_in(path);
  if (logs.empty()) throw ConfigRefused("decision log: no *.decisions in the folder " + path);
  return logs.back();
}

}  // namespace fairlead
