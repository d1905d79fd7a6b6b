// fairlead-safety: reads its configuration, opens its session, and hands every event to the core.
#include <fcntl.h>
#include <unistd.h>

#include <csignal>
#include <ctime>
#include <iostream>
#include <string>
#include <utility>
#include <vector>

#include "config/config_loader.hpp"
#include "config/config_origin.hpp"
#include "config/sha256.hpp"
#include "decisions/header.hpp"
#include "process/arguments.hpp"
#include "process/gate_process.hpp"
#include "process/latch_store.hpp"
#include "process/log_writer.hpp"
#include "process/refusal.hpp"
#include "process/self_test.hpp"
#include "zenoh/key_table.hpp"
#include "zenoh/zenoh_transport.hpp"

namespace {

using namespace fairlead;

// A gate that already serves this robot publishes a lease at least every 25 ms.
constexpr std::chrono::milliseconds kOtherGatePatience{300};

// Blocked in every thread, so that only `sigwait` in the main thread sees them.
sigset_t block_stop_signals() {
  sigset_t signals;
  sigemptyset(&signals);
  sigaddset(&signals, SIGTERM);
  sigaddset(&signals, SIGINT);
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  // A log reader or peer that goes away must not end the gate.
  std::signal(SIGPIPE, SIG_IGN);
  std::signal(SIGXFSZ, SIG_IGN);  // a file at its size limit is a failed write, no more
  return signals;
}

// Where the caller closed a standard stream, nothing else gets its number: lines of the log would
// go there.
void open_closed_streams() {
  int opened = 0;
  while (opened >= 0 && opened <= STDERR_FILENO) opened = ::open("/dev/null", O_RDWR);
  if (opened > STDERR_FILENO) ::close(opened);
}

const char* name_of(int signal) { return signal == SIGTERM ? "SIGTERM" : "SIGINT"; }

std::string wait_for_stop(const sigset_t& signals) {
  int signal = 0;
  sigwait(&signals, &signal);
  return name_of(signal);
}

/// Asked to end before the gate was up.
struct EndedEarly {};

/// Says what the gate waits for, now and every tenth time, unless it was asked to end.
class RouterWait {
 public:
  RouterWait(std::string router, const sigset_t& signals, LogWriter& log)
      : router_(std::move(router)), signals_(signals), log_(log) {}

  void operator()() {
    const timespec at_once{};
    const int signal = sigtimedwait(&signals_, nullptr, &at_once);
    if (signal > 0) {
      log_.info(std::string("ends on ") + name_of(signal) + " before it reached the router");
      throw EndedEarly();
    }
    if (attempts_++ % 10 == 0) log_.warning("waiting for the router " + router_);
  }

 private:
  std::string router_;
  const sigset_t& signals_;
  LogWriter& log_;
  int attempts_ = 0;
};

void say_known_answers(const Limits& limits, LogWriter& log) {
  const std::uint64_t began_ns = monotonic_ns();
  const std::size_t answers = self_test(limits);
  log.info("self-test: " + std::to_string(answers) + " known answers in " +
           std::to_string((monotonic_ns() - began_ns) / 1000U) + " us");
}

/// Ends what the network calls before what it calls goes, also where starting fails half-way.
class Listening {
 public:
  explicit Listening(ZenohTransport& transport) : transport_(transport) {}
  ~Listening() { transport_.stop_listening(); }
  Listening(const Listening&) = delete;
  Listening& operator=(const Listening&) = delete;

 private:
  ZenohTransport& transport_;
};

void run(const Arguments& arguments) {
  const KeyTable keys(arguments.name_space, arguments.robot);
  if (!is_key_chunk(arguments.service)) {
    throw ConfigRefused("--service: expected 1 to 64 of a-z 0-9 _ . -, got '" + arguments.service +
                        "'");
  }
  const auto limits = load_limits(arguments.config);
  const std::string origin = check_origin(arguments.config);
  const sigset_t signals = block_stop_signals();
  LogWriter log(arguments.service);
  say_known_answers(*limits, log);
  if (arguments.endpoints.access.empty()) {
    log.warning("access is open: whoever reaches this gate may move the robot");
  }
  ZenohTransport transport(arguments.endpoints, keys,
                           RouterWait(arguments.endpoints.router, signals, log));
  if (transport.hears_another_gate(kOtherGatePatience)) {
    throw StartFailed("another gate already serves the robot " + arguments.robot +
                      "; see: fairlead ps");
  }
  std::string header = make_header(*limits, arguments.config);
  // Not before: a folder once used without a clean mark is one in which the robot was armed.
  LatchStore store(arguments.state_dir, [&log](const std::string& fault) { log.warning(fault); });
  DecisionLog decisions(
      {arguments.decision_log, arguments.decision_log_files, arguments.decision_log_mib << 20U},
      std::move(header), log);
  ServiceManager manager;
  GateProcess process(*limits, arguments.config, store, log, decisions, transport, manager);
  log.info("configuration " + arguments.config + " (profile " +
           std::string(limits->profile.view()) + ") hash " + to_hex(limits->config_hash) + ", " +
           origin);
  process.start(arguments.new_state);
  const Listening listening(transport);
  transport.listen(
      [&process](const Event& event, Answer* answer) { process.handle(event, answer); });
  transport.announce(arguments.service);
  log.info("ready");
  manager.say_ready();
  log.info("ends on " + wait_for_stop(signals));
  transport.stop_listening();
  process.shut_down();
}

int report(const std::exception& error, int status) {
  std::cout << "ERROR fairlead-safety: " << error.what() << std::endl;
  return status;
}

}  // namespace

int main(int count, char** words) {
  open_closed_streams();
  try {
    const std::vector<std::string> given(words + 1, words + count);
    if (given.size() == 2 && given[0] == "check") return check_command(given[1]);
    const Arguments arguments = parse_arguments(given);
    if (arguments.help) {
      std::cout << usage();
      return 0;
    }
    run(arguments);
    return 0;
  } catch (const EndedEarly&) {
    return 0;
  } catch (const ConfigRefused& refusal) {
    return report(refusal, 2);
  } catch (const std::exception& error) {
    return report(error, 1);
  }
}
