// Claims and releases in another's name.
#pragma once

#include <string>

#include "fairlead_safety/gate.hpp"

namespace fairlead {

/// What is wrong where a claim or release names another source than its key does, else "". Access
/// control lets a service ask on its own key alone; the name in the message is its own word.
std::string foreign_name(const Event& event);

}  // namespace fairlead
