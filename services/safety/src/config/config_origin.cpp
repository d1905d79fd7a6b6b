#include "config/config_origin.hpp"

#include <fstream>
#include <iostream>
#include <iterator>
#include <optional>
#include <string_view>

#include "config/config_loader.hpp"
#include "config/sha256.hpp"
#include "config/strict_json.hpp"
#include "process/refusal.hpp"

namespace fairlead {
namespace {

using nlohmann::json;
namespace fs = std::filesystem;

constexpr std::string_view kDigestKey = "\"content_sha256\"";
constexpr std::string_view kManifest = "robot.yaml";

std::optional<std::string> bytes_of(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  if (!stream || fs::is_directory(file)) return std::nullopt;
  return std::string{std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
}

std::string digest(std::string_view text) {
  return to_hex(sha256(Bytes(reinterpret_cast<const std::uint8_t*>(text.data()), text.size())));
}

// Nothing follows the digest but the end of the document, or it could say something unnoticed.
bool is_sealed(std::string_view text, const std::string& told) {
  const std::size_t key = text.rfind(kDigestKey);
  if (key == std::string_view::npos) return false;
  std::string rest;
  for (const char c : text.substr(key + kDigestKey.size()))
    if (c != ' ' && c != '\n') rest += c;
  return rest == ":\"" + told + "\"}" && told == digest(text.substr(0, key));
}

std::string changed_beside(const fs::path& folder, const json& sources) {
  std::string names;
  for (const auto& [name, told] : sources.items()) {
    const std::optional<std::string> found = bytes_of(folder / name);
    if (!found || json(digest(*found)) != told) names += (names.empty() ? "" : ", ") + name;
  }
  return names;
}

[[noreturn]] void refuse_origin(const fs::path& file, const json& document,
                                const std::string& what) {
  const std::string robot =
      document.contains("robot") && document["robot"].is_string() ? document["robot"] : "ROBOT";
  throw ConfigRefused("configuration " + file.string() + ": " + what +
                      "; make it anew with: fairlead robot compile " + robot);
}

}  // namespace

std::string check_origin(const fs::path& file) {
  const std::string text = bytes_of(file).value_or("");
  const json document = parse_strictly(text);
  const json told = document.value("content_sha256", json());
  const json sources = document.value("compiled_from", json());
  if (!told.is_string() || !sources.is_object() || !sources.contains(kManifest))
    refuse_origin(file, document,
                  "content_sha256, compiled_from: expected what it was compiled from, got none");
  if (!is_sealed(text, told.get<std::string>()))
    refuse_origin(file, document,
                  "content_sha256: expected the file as it was compiled, got one that was edited "
                  "afterwards; limits are changed in robot.yaml");
  const fs::path folder = file.parent_path();
  if (!fs::exists(folder / kManifest))
    return "as it was compiled; no robot.yaml beside it to compare with";
  const std::string changed = changed_beside(folder, sources);
  if (!changed.empty())
    refuse_origin(
        file, document,
        "compiled_from: expected the files beside it as they were, got others: " + changed);
  return "as it was compiled from the robot.yaml beside it";
}

int check_command(const std::string& file) {
  load_limits(file);
  std::cout << file << ": " << check_origin(file) << std::endl;
  return 0;
}

}  // namespace fairlead
