#include "zenoh/listen_port.hpp"

#include <netdb.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>

#include "process/refusal.hpp"

namespace fairlead {
namespace {

bool is_taken(const addrinfo& address) {
  const int fd = ::socket(address.ai_family, address.ai_socktype, address.ai_protocol);
  if (fd < 0) return false;
  const int reuse = 1;  // connections of an earlier process that are still closing do not count
  ::setsockopt(fd, SOL_SOCKET, SO_REUSEADDR, &reuse, sizeof(reuse));
  const bool taken = ::bind(fd, address.ai_addr, address.ai_addrlen) != 0 && errno == EADDRINUSE;
  ::close(fd);
  return taken;
}

}  // namespace

void check_listen_port(const std::string& endpoint) {
  const std::size_t colon = endpoint.rfind(':');
  if (!endpoint.starts_with("tcp/") || colon == std::string::npos) return;
  const std::string host = endpoint.substr(4, colon - 4);
  const std::string port = endpoint.substr(colon + 1);
  addrinfo hints{};
  hints.ai_socktype = SOCK_STREAM;
  hints.ai_flags = AI_PASSIVE;
  addrinfo* found = nullptr;
  if (::getaddrinfo(host.c_str(), port.c_str(), &hints, &found) != 0) return;
  const bool taken = is_taken(*found);
  ::freeaddrinfo(found);
  if (taken) {
    throw StartFailed("port " + port + " (" + endpoint +
                      ") is in use by another process; see which: fairlead ps");
  }
}

}  // namespace fairlead
