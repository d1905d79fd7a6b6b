#include "process/foreign_name.hpp"

#include "fairlead_safety/codec.hpp"
#include "fairlead_safety/messages.hpp"

namespace fairlead {
namespace {

template <class Message>
std::string_view name_in(const Message& message) {
  if constexpr (requires { message.source; })
    return message.source.view();
  else
    return person_of(message.by);
}

// What does not decode is the core's to refuse, with its reason.
template <class Message>
std::string foreign(const Event& event) {
  Message message;
  if (decode(event.payload, message) != FrameFault::none || name_in(message) == event.source)
    return {};
  return "asked in the name of " + std::string(name_in(message)) + " on the key of " +
         std::string(event.source);
}

}  // namespace

std::string foreign_name(const Event& event) {
  if (event.kind == EventKind::claim) return foreign<Claim>(event);
  if (event.kind == EventKind::release) return foreign<Release>(event);
  if (event.source.empty()) return {};  // a command on a key that is nobody's
  if (event.kind == EventKind::arm) return foreign<Arm>(event);
  if (event.kind == EventKind::disarm) return foreign<Disarm>(event);
  if (event.kind == EventKind::reset) return foreign<Reset>(event);
  return {};
}

}  // namespace fairlead
