// Where the gate meets the others on Zenoh, and the session configuration that follows from it.
#pragma once

#include <string>
#include <vector>

namespace fairlead {

/// Either a peer, which listens and connects, or a client of one router.
struct Endpoints {
  std::string listen;                // peer: where others reach this process
  std::vector<std::string> connect;  // peer: whom it connects to, tried for ever
  std::string router;                // not empty: a client of it; the two above are empty
  std::string access;                // file: who this process is, whom it lets do what; "": open
};

/// The session's configuration as JSON: static endpoints, no discovery, endless reconnection. For
/// a client, opening a session gives up after two seconds, so that somebody can be told.
/// Throws ConfigRefused, naming a file of access that cannot be used.
std::string session_config(const Endpoints& endpoints);

/// Zenoh closes a dead TCP link in one of its receive threads, and waits there up to 10 s for what
/// was not sent; a client gets more of them than the usual two. A connection that never said
/// anything it closes where it accepts; a peer gets more threads there, else nothing is read
/// meanwhile of the links that it dialled. Before the first session.
void prepare_runtime(const Endpoints& endpoints);

}  // namespace fairlead
