// The gate as one state machine: an event and the time in, a list of things to do out.
//
// No clock, no I/O, no allocation after construction, no exceptions. Not thread-safe: the
// shell serialises its events. Before the first event, call `boot` once.
#pragma once

#include <cstdint>
#include <memory>
#include <string_view>

#include "fairlead_safety/fixed.hpp"
#include "fairlead_safety/limits.hpp"
#include "fairlead_safety/outputs.hpp"
#include "fairlead_safety/query_messages.hpp"

namespace fairlead {

enum class EventKind : std::uint8_t {
  timer = 0,        // at least every 5 ms; no payload
  joint_state = 1,  // state/joints
  candidate = 2,    // action/candidate/<source>
  hal_status = 3,   // hal/status, published or queried
  heartbeat = 4,    // skill/<source>/heartbeat
  stop_level = 5,   // safety/stop
  arm = 6,          // queries: exactly one reply or refusal each
  disarm = 7,
  reset = 8,
  claim = 9,
  release = 10,
  status = 11,
  lease = 12,  // safety/lease of anybody: a second gate's
};

struct Event {
  EventKind kind = EventKind::timer;
  std::string_view source;        // the source or person in the key, "source/person"; else empty
  Bytes payload;                  // as received; only read during the step
  std::uint64_t received_ns = 0;  // same clock as `now_ns`; a verdict's latency counts from here
  // G050: how long the step before took, until its outputs were sent; at most 4.29 s are told.
  std::uint32_t previous_step_ns = 0;
};

/// Where ids come from (claims, epochs, stops, latches). The shell's is random; a test's is not.
class IdSource {
 public:
  virtual ~IdSource() = default;
  virtual std::uint64_t next_id() = 0;  // 0 is drawn again
};

/// What the shell found on disk.
struct BootInfo {
  bool first_start = false;  // the state folder has never been used
  bool clean_mark = false;   // the last process left while disarmed
  Bytes latch;               // payload of the last persist_latch, empty if cleared or none
  bool new_state = false;    // the operator says that a first start is right
};

class Gate {
 public:
  /// `limits` has passed check_limits. `ids` must outlive the gate.
  Gate(const Limits& limits, IdSource& ids);
  ~Gate();
  Gate(const Gate&) = delete;
  Gate& operator=(const Gate&) = delete;

  /// Leave boot: to disarmed, or to latched if a latch was persisted or the last exit was not
  /// clean.
  void boot(std::uint64_t now_ns, const BootInfo& info, Outputs& outputs);

  /// Handle one event at `now_ns` (monotonic, never decreasing). `outputs` is cleared first.
  void step(std::uint64_t now_ns, const Event& event, Outputs& outputs);

  [[nodiscard]] GateState state() const;

 private:
  class Core;
  std::unique_ptr<Core> core_;
};

}  // namespace fairlead
