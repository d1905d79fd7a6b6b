#include "process/service_manager.hpp"

#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <charconv>
#include <cstddef>
#include <cstdlib>
#include <cstring>

namespace fairlead {
namespace {

constexpr std::uint64_t kTimesPerWatchdog = 4;

std::string_view environment(const char* name) {
  const char* value = std::getenv(name);
  return value == nullptr ? std::string_view() : std::string_view(value);
}

}  // namespace

ServiceManager::ServiceManager() : socket_(environment("NOTIFY_SOCKET")) {
  const std::string_view text = environment("WATCHDOG_USEC");
  std::uint64_t microseconds = 0;
  if (std::from_chars(text.data(), text.data() + text.size(), microseconds).ec == std::errc()) {
    period_ns_ = microseconds * 1000 / kTimesPerWatchdog;
  }
}

void ServiceManager::say_alive(std::uint64_t now_ns) {
  if (period_ns_ == 0 || now_ns - said_ns_ < period_ns_) return;
  said_ns_ = now_ns;
  tell("WATCHDOG=1");
}

void ServiceManager::tell(std::string_view state) const {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  if (socket_.empty() || socket_.size() >= sizeof address.sun_path) return;
  std::memcpy(address.sun_path, socket_.data(), socket_.size());
  if (address.sun_path[0] == '@') address.sun_path[0] = '\0';  // a name that is no file
  const int file = ::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  if (file < 0) return;
  const auto size = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + socket_.size());
  ::sendto(file, state.data(), state.size(), MSG_NOSIGNAL,
           reinterpret_cast<const sockaddr*>(&address), size);
  ::close(file);
}

}  // namespace fairlead
