// Says in advance, and in words, that a listening port is taken.
#pragma once

#include <string>

namespace fairlead {

/// Throws StartFailed naming the port if `endpoint` (tcp/HOST:PORT) cannot be listened on
/// because another process does. Other endpoints, and other faults, are left to Zenoh.
void check_listen_port(const std::string& endpoint);

}  // namespace fairlead
