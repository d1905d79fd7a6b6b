#include "process/foreign_name.hpp"

#include "fairlead_safety/codec.hpp"
#include "fairlead_safety/query_messages.hpp"

namespace fairlead {
namespace {

std::string foreign(std::string_view named, std::string_view owner) {
  if (named == owner) return {};
  return "asked in the name of " + std::string(named) + " on the key of " + std::string(owner);
}

// What does not decode is the core's to refuse, with its reason.
template <class Message>
std::string foreign_source(const Event& event, std::string_view source) {
  Message message;
  if (decode(event.payload, message) != FrameFault::none) return {};
  return foreign(message.source.view(), source);
}

template <class Message>
std::string foreign_person(const Event& event, std::string_view person) {
  Message message;
  if (decode(event.payload, message) != FrameFault::none) return {};
  return foreign(person_of(message.by), person);
}

std::string foreign_claim(const Event& event) {
  const std::size_t slash = event.source.find('/');
  const std::string found = foreign_source<Claim>(event, event.source.substr(0, slash));
  if (!found.empty() || slash == std::string_view::npos) return found;
  return foreign_person<Claim>(event, event.source.substr(slash + 1));
}

}  // namespace

std::string foreign_name(const Event& event) {
  if (event.kind == EventKind::claim) return foreign_claim(event);
  if (event.kind == EventKind::release) return foreign_source<Release>(event, event.source);
  if (event.source.empty()) return {};  // a command on a key that is nobody's
  if (event.kind == EventKind::arm) return foreign_person<Arm>(event, event.source);
  if (event.kind == EventKind::disarm) return foreign_person<Disarm>(event, event.source);
  if (event.kind == EventKind::reset) return foreign_person<Reset>(event, event.source);
  return {};
}

}  // namespace fairlead
