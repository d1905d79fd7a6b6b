#include "decisions/header.hpp"

#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>

#include "config/config_loader.hpp"
#include "config/sha256.hpp"
#include "process/refusal.hpp"
#include "process/utc_time.hpp"

namespace fairlead {
namespace {

using nlohmann::json;

std::string text_of_file(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

Hash hash_of(const std::string& text) {
  return sha256(Bytes(reinterpret_cast<const std::uint8_t*>(text.data()), text.size()));
}

}  // namespace

// The gate writes a log, and the program beside it reads one.
std::string hash_of_this_gate() {
  std::error_code error;
  const std::filesystem::path self = std::filesystem::read_symlink("/proc/self/exe", error);
  const std::string program = text_of_file(self.parent_path() / "fairlead-safety");
  return program.empty() ? "" : to_hex(hash_of(program));
}

std::string make_header(const Limits& limits, const std::string& config_file) {
  const std::string config = text_of_file(config_file);
  if (hash_of(config) != limits.config_hash)
    throw StartFailed("configuration " + config_file + " changed while the gate was starting");
  return json{{"robot", limits.robot.view()},
              {"profile", limits.profile.view()},
              {"gate", hash_of_this_gate()},
              {"started", utc_now()},
              {"config_file", std::filesystem::absolute(config_file).string()},
              {"config", config}}
      .dump();
}

LogHeader read_header(const std::string& text) {
  try {
    const json document = json::parse(text);
    return {document.at("robot"),   document.at("profile"),     document.at("gate"),
            document.at("started"), document.at("config_file"), document.at("config")};
  } catch (const json::exception& fault) {
    throw ConfigRefused(std::string("decision log: header: ") + fault.what());
  }
}

std::unique_ptr<Limits> recorded_limits(const LogHeader& header) {
  try {
    return parse_limits(header.config);
  } catch (const ConfigRefused& refusal) {
    throw ConfigRefused("decision log: its configuration does not fit this gate, which is " +
                        std::string(header.gate == hash_of_this_gate() ? "the" : "not the") +
                        " one that wrote it: " + refusal.what());
  }
}

}  // namespace fairlead
