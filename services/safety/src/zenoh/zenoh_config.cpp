#include "zenoh/zenoh_config.hpp"

#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>

#include "process/refusal.hpp"

namespace fairlead {
namespace {

// A link that was silent for so long is closed by Zenoh, and made anew. Never a watchdog: motion
// ends far earlier, by leases and heartbeats.
constexpr int kLinkSilenceMs = 2000;
constexpr int kOpenPatienceMs = 2000;
// An answer for which a link has no room is waited for, by whoever holds the gate's lock; then the
// link is closed. Zenoh's own 5 s would be 5 s without a lease.
constexpr int kAnswerWaitUs = 5000;
// Connections that say nothing are let wait for so long. Beyond its own 100 of them Zenoh turns
// each away at once, at the cost of 4 ms in which nothing is received.
constexpr int kAcceptPending = 10'000;

int open_patience_ms(const Endpoints& endpoints) {
  if (!endpoints.router.empty()) return kOpenPatienceMs;
  return endpoints.connect.empty() ? 0 : -1;  // a peer opens at once and connects when it can
}

// A part of the configuration, made by whoever starts the gate. It has a password in it: what is
// wrong with it is said without a word of it.
nlohmann::json access_in(const std::string& file) {
  std::ifstream stream(file);
  const auto access = nlohmann::json::parse(stream, nullptr, false);
  if (!access.is_object() || !access.contains("access_control")) {
    throw ConfigRefused("--access " + file +
                        ": expected a JSON object with access_control, as `fairlead up` writes it");
  }
  return access;
}

}  // namespace

std::string session_config(const Endpoints& endpoints) {
  using nlohmann::json;
  const bool client = !endpoints.router.empty();
  const json retry = {
      {"period_init_ms", 50}, {"period_max_ms", 500}, {"period_increase_factor", 2}};
  const json off = {{"enabled", false}};
  // An express message takes a whole batch, so a step's burst must find room for each. Where
  // there is none the message is dropped at once: whoever puts holds the gate's lock. Answers have
  // to arrive; who asks and does not read them loses its link.
  const json queue = {
      {"size", {{"real_time", 16}, {"data", 4}}},
      {"congestion_control",
       {{"drop", {{"wait_before_drop", 0}}}, {"block", {{"wait_before_close", kAnswerWaitUs}}}}}};
  json transport = {
      {"link", {{"tx", {{"queue", queue}}}}},
      {"unicast", {{"accept_timeout", kLinkSilenceMs}, {"accept_pending", kAcceptPending}}}};
  if (client) {
    transport["link"]["tx"]["lease"] = kLinkSilenceMs;
    transport["unicast"]["open_timeout"] = kLinkSilenceMs;
  }
  json config = {
      {"mode", client ? "client" : "peer"},
      {"transport", transport},
      {"connect",
       {{"endpoints", client ? std::vector<std::string>{endpoints.router} : endpoints.connect},
        {"timeout_ms", open_patience_ms(endpoints)},
        {"exit_on_failure", false},
        {"retry", retry}}},
      {"scouting", {{"multicast", off}, {"gossip", off}}},
      {"timestamping", off},
      {"adminspace", off}};
  const json listen = client ? json::array() : json::array({endpoints.listen});
  config["listen"] = {{"endpoints", listen}, {"exit_on_failure", true}};
  if (!endpoints.access.empty()) config.merge_patch(access_in(endpoints.access));
  return config.dump();
}

void prepare_runtime(const Endpoints& endpoints) {
  const int keep = 0;  // whoever set it knows better
  // Of a TLS link Zenoh 1.10 reads and writes one state without a lock, from two threads: memory
  // was broken and a gate aborted (its issue 2557). One thread does both. It also closes a dead
  // link, and waits up to 10 s for what was not sent: so long the gate may take to connect anew.
  // A peer, which has no such link, has one large pool (`RUNTIME` in endpoints.py says why).
  const char* threads = endpoints.router.empty()
                            ? "(acc: (worker_threads: 16), rx: (handover: acc), "
                              "tx: (handover: acc), net: (handover: acc))"
                            : "(rx: (worker_threads: 1), tx: (handover: rx))";
  ::setenv("ZENOH_RUNTIME", threads, keep);
}

}  // namespace fairlead
