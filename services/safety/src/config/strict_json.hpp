// JSON read strictly: each key is asked for once, and what nobody asked for is refused.
//
// Every refusal names the path of the key, for example `joints[2].bounds.lower`.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <string_view>

#include "process/refusal.hpp"

namespace fairlead {

/// Parse a file's text. Refuses malformed text, duplicate keys and numbers beyond float64.
nlohmann::json parse_strictly(std::string_view text);

/// One object of the document, with its path.
class Section {
 public:
  /// Throws ConfigRefused if `node` is not an object.
  Section(const nlohmann::json& node, std::string path);

  bool has(const char* key) const { return node_.contains(key); }
  double number(const char* key);
  bool boolean(const char* key);
  /// From `lowest` up to what 53 bits hold exactly, or `highest`.
  std::uint64_t integer(const char* key, std::uint64_t lowest, std::uint64_t highest);
  std::string text(const char* key, std::size_t longest);
  Section section(const char* key);
  const nlohmann::json& list(const char* key);
  /// Whatever is there, null too.
  const nlohmann::json& any(const char* key);

  std::string path_of(std::string_view key) const;
  std::string path_of(std::string_view key, std::size_t index) const;
  const nlohmann::json& node() const { return node_; }

  /// Refuse any key that was not asked for; call it last.
  void refuse_unknown_keys() const;

 private:
  const nlohmann::json& get(const char* key);

  const nlohmann::json& node_;
  std::string path_;
  std::set<std::string, std::less<>> known_;
};

/// Throws ConfigRefused: "PATH: expected WANTED, got GOT".
[[noreturn]] void refuse(const std::string& path, const std::string& wanted,
                         const nlohmann::json& got);

}  // namespace fairlead
