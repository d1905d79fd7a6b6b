#include <doctest/doctest.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

#include "process/arguments.hpp"
#include "process/refusal.hpp"
#include "zenoh/zenoh_config.hpp"

using namespace fairlead;
using nlohmann::json;

namespace {

std::vector<std::string> words_with(const std::vector<std::string>& endpoints) {
  std::vector<std::string> words = {"--robot", "r", "--config", "c", "--state-dir", "s"};
  words.insert(words.end(), endpoints.begin(), endpoints.end());
  return words;
}

std::string complaint_about(const std::vector<std::string>& endpoints) {
  try {
    parse_arguments(words_with(endpoints));
  } catch (const ConfigRefused& refusal) {
    return refusal.what();
  }
  return "";
}

}  // namespace

TEST_CASE("a peer listens, and connects to others for ever") {
  const auto arguments =
      parse_arguments(words_with({"--listen", "tcp/a:1", "--connect", "tcp/b:2"}));
  const json config = json::parse(session_config(arguments.endpoints));
  CHECK(config["mode"] == "peer");
  CHECK(config["listen"]["endpoints"] == json::array({"tcp/a:1"}));
  CHECK(config["connect"]["endpoints"] == json::array({"tcp/b:2"}));
  CHECK(config["connect"]["timeout_ms"] == -1);
}

TEST_CASE("a client listens nowhere and connects to its router alone") {
  const auto arguments = parse_arguments(words_with({"--router", "tcp/r:1"}));
  const json config = json::parse(session_config(arguments.endpoints));
  CHECK(config["mode"] == "client");
  CHECK(config["listen"]["endpoints"] == json::array());
  CHECK(config["connect"]["endpoints"] == json::array({"tcp/r:1"}));
  CHECK(config["connect"]["timeout_ms"] == 2000);
  CHECK(config["transport"]["link"]["tx"]["lease"] == 2000);
}

TEST_CASE("nothing waits for room on a link, whatever the mode") {
  for (const Endpoints& endpoints :
       {Endpoints{"tcp/a:1", {}, "", ""}, Endpoints{"", {}, "tcp/r:1", ""}}) {
    const json config = json::parse(session_config(endpoints));
    const json& queue = config["transport"]["link"]["tx"]["queue"];
    CHECK(queue["congestion_control"]["drop"]["wait_before_drop"] == 0);
    CHECK(queue["congestion_control"]["block"]["wait_before_close"] == 5000);
    CHECK(queue["size"]["real_time"] == 16);
    CHECK(config["scouting"]["multicast"]["enabled"] == false);
  }
}

TEST_CASE("a gate is a peer or a client, and says which arguments that takes") {
  CHECK(complaint_about({"--listen", "tcp/a:1"}) == "");
  CHECK(complaint_about({}) ==
        "--listen or --router: expected one of them; see: fairlead-safety --help");
  CHECK(complaint_about({"--listen", "tcp/a:1", "--router", "tcp/r:1"}) ==
        "--listen or --router: expected one of them; see: fairlead-safety --help");
  CHECK(complaint_about({"--router", "tcp/r:1", "--connect", "tcp/b:2"}) ==
        "--connect: not with --router, whose client connects to it alone");
}

TEST_CASE("who may do what is a part of the configuration, and its file must have it") {
  const auto folder = std::filesystem::temp_directory_path() / "fairlead-test-access";
  std::filesystem::create_directories(folder);
  const std::string file = folder / "safety.json";
  const auto config_with = [&file](const std::string& text) {
    std::ofstream(file) << text;
    return session_config({"tcp/a:1", {}, "", file});
  };
  const json config = json::parse(config_with(
      R"({"id": "f1", "transport": {"auth": {"usrpwd": {}}}, "access_control": {"enabled": true}})"));
  CHECK(config["id"] == "f1");
  CHECK(config["access_control"]["enabled"] == true);
  CHECK(config["transport"]["auth"]["usrpwd"] == json::object());
  CHECK(config["transport"]["link"]["tx"]["queue"]["size"]["real_time"] == 16);
  for (const char* text : {"", "{", "[1]", R"({"secret": 1})"}) {
    CHECK_THROWS_WITH_AS(
        config_with(text),
        ("--access " + file +
         ": expected a JSON object with access_control, as `fairlead up` writes it")
            .c_str(),
        ConfigRefused);
  }
  std::filesystem::remove_all(folder);
  CHECK_THROWS_AS(session_config({"tcp/a:1", {}, "", file}), ConfigRefused);
}
