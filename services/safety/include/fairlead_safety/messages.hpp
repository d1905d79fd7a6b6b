// The wire messages that the gate reads or writes, field for field in wire order.
#pragma once

#include "fairlead_safety/action_messages.hpp"
#include "fairlead_safety/query_messages.hpp"
#include "fairlead_safety/robot_messages.hpp"
