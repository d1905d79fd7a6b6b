// bare-relay: receives on one key and sends the same bytes on another, in the callback.
//
// The yardstick for the gate's own cost: same Zenoh library, same quality of service, no
// decision. Used by bench/gate_hop.py.
//
//   bare-relay tcp/127.0.0.1:7601 fl/bench/in fl/bench/out [KEY...]
//
// On each further KEY it sends a short message after it, as the gate sends a lease and a verdict.
#include <zenoh.h>

#include <array>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <deque>
#include <string>

#include "process/thread_handover.hpp"

namespace {

constexpr std::size_t short_message = 200;  // about a lease or a verdict

std::array<std::uint8_t, 65536> buffer;  // one sender, so one callback at a time

using Publishers =
    std::deque<z_owned_publisher_t>;  // of the message itself, then of the short ones

void put(const z_owned_publisher_t& publisher, std::size_t size) {
  z_owned_bytes_t copy;
  z_bytes_copy_from_buf(&copy, buffer.data(), size);
  z_publisher_put(z_loan(publisher), z_move(copy), nullptr);
}

void relay(z_loaned_sample_t* sample, void* context) {
  fairlead::take_over(context);
  const z_loaned_bytes_t* payload = z_sample_payload(sample);
  z_bytes_reader_t reader = z_bytes_get_reader(payload);
  const std::size_t size = z_bytes_reader_read(&reader, buffer.data(), buffer.size());
  const Publishers& publishers = *static_cast<const Publishers*>(context);
  put(publishers.front(), size);
  for (std::size_t i = 1; i < publishers.size(); ++i) put(publishers[i], short_message);
}

bool open_session(z_owned_session_t* session, const std::string& listen) {
  const std::string json =
      R"({"mode":"peer","listen":{"endpoints":[")" + listen +
      R"("]},"scouting":{"multicast":{"enabled":false},"gossip":{"enabled":false}},)"
      R"("transport":{"link":{"tx":{"queue":{"size":{"real_time":16}}}}}})";
  z_owned_config_t config;
  return zc_config_from_str(&config, json.c_str()) == Z_OK &&
         z_open(session, z_move(config), nullptr) == Z_OK;
}

bool publish_on(const z_owned_session_t& session, const char* to, bool is_express,
                Publishers& publishers) {
  z_publisher_options_t options;
  z_publisher_options_default(&options);
  options.priority = Z_PRIORITY_REAL_TIME;
  options.is_express = is_express;
  z_view_keyexpr_t key;
  return z_view_keyexpr_from_str(&key, to) == Z_OK &&
         z_declare_publisher(z_loan(session), &publishers.emplace_back(), z_loan(key), &options) ==
             Z_OK;
}

bool subscribe(const z_owned_session_t& session, const char* from, Publishers& publishers,
               z_owned_subscriber_t* subscriber) {
  z_view_keyexpr_t key;
  z_owned_closure_sample_t callback;
  fairlead::hand_over(&publishers);
  z_closure_sample(&callback, relay, nullptr, &publishers);
  return z_view_keyexpr_from_str(&key, from) == Z_OK &&
         z_declare_subscriber(z_loan(session), subscriber, z_loan(key), z_move(callback),
                              nullptr) == Z_OK;
}

}  // namespace

int main(int count, char** words) {
  if (count < 4) {
    std::puts("usage: bare-relay LISTEN-ENDPOINT KEY-IN KEY-OUT [KEY...]");
    return 2;
  }
  sigset_t signals;
  sigemptyset(&signals);
  sigaddset(&signals, SIGTERM);
  sigaddset(&signals, SIGINT);
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  z_owned_session_t session;
  Publishers publishers;
  z_owned_subscriber_t subscriber;
  bool ready = open_session(&session, words[1]);
  for (int i = 3; i < count; ++i) {
    const bool rides = i == 3 && count > 4;  // with the next one, as a SafeChunk with its lease
    ready = ready && publish_on(session, words[i], !rides, publishers);
  }
  if (!ready || !subscribe(session, words[2], publishers, &subscriber)) {
    std::printf("ERROR bare-relay: cannot listen on %s\n", words[1]);
    return 1;
  }
  std::puts("ready");
  std::fflush(stdout);
  int signal = 0;
  sigwait(&signals, &signal);
  z_drop(z_move(subscriber));
  for (z_owned_publisher_t& publisher : publishers) z_drop(z_move(publisher));
  z_drop(z_move(session));
  return 0;
}
