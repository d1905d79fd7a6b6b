#include "process/foreign_name.hpp"

#include "fairlead_safety/codec.hpp"
#include "fairlead_safety/messages.hpp"

namespace fairlead {
namespace {

// What does not decode is the core's to refuse, with its reason.
template <class Message>
std::string foreign_source(const Event& event) {
  Message message;
  if (decode(event.payload, message) != FrameFault::none || message.source == event.source)
    return {};
  return "asked in the name of " + std::string(message.source.view()) + " on the key of " +
         std::string(event.source);
}

}  // namespace

std::string foreign_name(const Event& event) {
  if (event.kind == EventKind::claim) return foreign_source<Claim>(event);
  if (event.kind == EventKind::release) return foreign_source<Release>(event);
  return {};
}

}  // namespace fairlead
