// Says in advance, and in words, that a listening port or socket is taken.
#pragma once

#include <string>

namespace fairlead {

/// Throws StartFailed naming the place if `endpoint` (tcp/HOST:PORT, unixsock-stream/PATH) cannot
/// be listened on because another process does. Other endpoints, and other faults, are left to
/// Zenoh.
void check_listen_place(const std::string& endpoint);

}  // namespace fairlead
