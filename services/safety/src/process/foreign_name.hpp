// Queries in another's name.
#pragma once

#include <string>

#include "fairlead_safety/gate.hpp"

namespace fairlead {

/// What is wrong where a query names another source or person than its key does, else "". Access
/// control lets everybody ask on their own key alone; the name in the message is their own word.
std::string foreign_name(const Event& event);

}  // namespace fairlead
