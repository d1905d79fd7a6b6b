#include "config/strict_json.hpp"

#include <cmath>
#include <utility>
#include <vector>

namespace fairlead {
namespace {

using nlohmann::json;

// More than any gate file has; whoever walks through a document calls itself as often.
constexpr std::size_t deepest = 32;

// Follows the parser through the document, to name the place of a fault.
class PlaceTracker {
 public:
  bool operator()(json::parse_event_t event, const json& parsed) {
    switch (event) {
      case json::parse_event_t::object_start:
        enter({});
        break;
      case json::parse_event_t::array_start:
        enter({.is_array = true});
        break;
      case json::parse_event_t::key:
        enter_key(parsed.get<std::string>());
        break;
      case json::parse_event_t::object_end:
      case json::parse_event_t::array_end:
        open_.pop_back();
        [[fallthrough]];
      case json::parse_event_t::value:
        leave_value();
        break;
    }
    return true;
  }

  std::string path() const {
    std::string text;
    for (const Level& level : open_) {
      if (level.is_array) {
        text += "[" + std::to_string(level.index) + "]";
      } else if (!level.key.empty()) {
        text += (text.empty() ? "" : ".") + level.key;
      }
    }
    return text.empty() ? "the file" : text;
  }

 private:
  struct Level {
    bool is_array = false;
    std::size_t index = 0;
    std::string key = {};
    std::set<std::string> seen = {};
  };

  void enter(Level level) {
    if (open_.size() == deepest)
      throw ConfigRefused((open_.front().key.empty() ? "the file" : open_.front().key) +
                          ": expected values up to " + std::to_string(deepest) + " deep, got more");
    open_.push_back(std::move(level));
  }

  void enter_key(std::string key) {
    Level& level = open_.back();
    level.key = std::move(key);
    if (!level.seen.insert(level.key).second) throw ConfigRefused(path() + ": duplicate key");
  }
  void leave_value() {
    if (!open_.empty() && open_.back().is_array) ++open_.back().index;
  }

  std::vector<Level> open_;
};

}  // namespace

json parse_strictly(std::string_view text) {
  PlaceTracker place;
  try {
    return json::parse(text, [&place](int, json::parse_event_t event, const json& parsed) {
      return place(event, parsed);
    });
  } catch (const json::exception& error) {
    throw ConfigRefused(place.path() + ": expected JSON with finite numbers, got: " + error.what());
  }
}

void refuse(const std::string& path, const std::string& wanted, const json& got) {
  std::string shown = got.dump();
  if (shown.size() > 60) shown = shown.substr(0, 57) + "...";
  throw ConfigRefused(path + ": expected " + wanted + ", got " + shown);
}

Section::Section(const json& node, std::string path) : node_(node), path_(std::move(path)) {
  if (!node.is_object()) refuse(path_.empty() ? "the file" : path_, "an object", node);
}

std::string Section::path_of(std::string_view key) const {
  return path_.empty() ? std::string(key) : path_ + "." + std::string(key);
}

std::string Section::path_of(std::string_view key, std::size_t index) const {
  return path_of(key) + "[" + std::to_string(index) + "]";
}

const json& Section::get(const char* key) {
  known_.insert(key);
  const auto found = node_.find(key);
  if (found == node_.end()) throw ConfigRefused(path_of(key) + ": missing");
  return *found;
}

double Section::number(const char* key) {
  const json& value = get(key);
  if (!value.is_number()) refuse(path_of(key), "a number", value);
  return value.get<double>();
}

bool Section::boolean(const char* key) {
  const json& value = get(key);
  if (!value.is_boolean()) refuse(path_of(key), "true or false", value);
  return value.get<bool>();
}

std::uint64_t Section::integer(const char* key, std::uint64_t lowest, std::uint64_t highest) {
  const json& value = get(key);
  if (!value.is_number_unsigned() || value.get<std::uint64_t>() < lowest ||
      value.get<std::uint64_t>() > highest) {
    refuse(path_of(key),
           "a whole number from " + std::to_string(lowest) + " to " + std::to_string(highest),
           value);
  }
  return value.get<std::uint64_t>();
}

std::string Section::text(const char* key, std::size_t longest) {
  const json& value = get(key);
  if (!value.is_string() || value.get_ref<const std::string&>().empty() ||
      value.get_ref<const std::string&>().size() > longest) {
    refuse(path_of(key), "text of 1 to " + std::to_string(longest) + " bytes", value);
  }
  return value.get<std::string>();
}

Section Section::section(const char* key) { return Section(get(key), path_of(key)); }

const json& Section::list(const char* key) {
  const json& value = get(key);
  if (!value.is_array()) refuse(path_of(key), "a list", value);
  return value;
}

const json& Section::any(const char* key) { return get(key); }

void Section::refuse_unknown_keys() const {
  for (const auto& [key, value] : node_.items()) {
    if (known_.contains(key)) continue;
    std::string valid;
    for (const std::string& name : known_) valid += (valid.empty() ? "" : ", ") + name;
    throw ConfigRefused(path_of(key) + ": unknown key (valid: " + valid + ")");
  }
}

}  // namespace fairlead
