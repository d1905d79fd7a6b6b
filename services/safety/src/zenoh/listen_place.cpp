#include "zenoh/listen_place.hpp"

#include <fcntl.h>
#include <netdb.h>
#include <sys/file.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <string_view>

#include "process/refusal.hpp"

namespace fairlead {
namespace {

constexpr std::string_view kTcp = "tcp/";
constexpr std::string_view kSocket = "unixsock-stream/";

bool is_taken(const addrinfo& address) {
  const int fd = ::socket(address.ai_family, address.ai_socktype, address.ai_protocol);
  if (fd < 0) return false;
  const int reuse = 1;  // connections of an earlier process that are still closing do not count
  ::setsockopt(fd, SOL_SOCKET, SO_REUSEADDR, &reuse, sizeof(reuse));
  const bool taken = ::bind(fd, address.ai_addr, address.ai_addrlen) != 0 && errno == EADDRINUSE;
  ::close(fd);
  return taken;
}

bool is_taken_port(const std::string& host, const std::string& port) {
  addrinfo hints{};
  hints.ai_socktype = SOCK_STREAM;
  hints.ai_flags = AI_PASSIVE;
  addrinfo* found = nullptr;
  if (::getaddrinfo(host.c_str(), port.c_str(), &hints, &found) != 0) return false;
  const bool taken = is_taken(*found);
  ::freeaddrinfo(found);
  return taken;
}

// Zenoh locks a file beside a socket while it listens there.
bool is_taken_socket(const std::string& path) {
  const int fd = ::open((path + ".lock").c_str(), O_RDONLY | O_CLOEXEC);
  if (fd < 0) return false;
  const bool taken = ::flock(fd, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK;
  ::close(fd);
  return taken;
}

void check(bool is_taken, const std::string& place, const std::string& endpoint) {
  if (is_taken) {
    throw StartFailed(place + " (" + endpoint +
                      ") is in use by another process; see which: fairlead ps");
  }
}

}  // namespace

void check_listen_place(const std::string& endpoint) {
  const std::size_t colon = endpoint.rfind(':');
  if (endpoint.starts_with(kSocket)) {
    check(is_taken_socket(endpoint.substr(kSocket.size())), "its socket", endpoint);
  } else if (endpoint.starts_with(kTcp) && colon != std::string::npos) {
    const std::string host = endpoint.substr(kTcp.size(), colon - kTcp.size());
    const std::string port = endpoint.substr(colon + 1);
    check(is_taken_port(host, port), "port " + port, endpoint);
  }
}

}  // namespace fairlead
