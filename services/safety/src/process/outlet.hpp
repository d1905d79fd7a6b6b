// What the gate's process asks of its network. The Zenoh one is in zenoh_transport.
#pragma once

#include <string_view>

#include "fairlead_safety/fixed.hpp"
#include "fairlead_safety/outputs.hpp"

namespace fairlead {

/// Whether a SafeChunk leaves at once or in one piece with the lease that is published after it.
enum class Leaves : bool { now, with_next };

/// Sends what the core decided. `publish` never blocks and keeps the order of its calls.
class Outlet {
 public:
  virtual ~Outlet() = default;

  /// Make safe/<source> and verdict/<source> ready for `publish`; false if there are too many
  /// sources or the name cannot be in a key. `is_new`: they were not before. Not called with the
  /// gate's lock held, nor is `forget_source`.
  virtual bool prepare_source(std::string_view source, bool& is_new) = 0;
  /// Undo `prepare_source` for a source that nothing was, is or will be published for.
  virtual void forget_source(std::string_view source) = 0;
  /// `kind` is one of safe_chunk, verdict, lease, status. Unprepared sources are left out.
  /// `when`: of a safe_chunk; all others leave at once.
  virtual void publish(OutputKind kind, const Name& source, Bytes payload, Leaves when) = 0;
};

/// One query while it is being handled. Exactly one call is made.
class Answer {
 public:
  virtual ~Answer() = default;
  virtual void reply(Bytes payload) = 0;
  virtual void refuse(Bytes payload) = 0;
};

}  // namespace fairlead
