// The gate is its parts, in the order in which a chunk meets them, and a step that asks them one
// after the other.

#include "fairlead_safety/gate.hpp"

#include "core/gate/candidates.hpp"
#include "core/gate/publisher.hpp"
#include "core/gate/queries.hpp"
#include "core/gate/robot_events.hpp"

namespace fairlead {

class Gate::Core {
 public:
  Core(const Limits& limits, IdSource& ids) : limits_(limits), ids_(ids) {}

  void boot(std::uint64_t now_ns, const BootInfo& info, Outputs& outputs);
  void step(std::uint64_t now_ns, const Event& event, Outputs& outputs);
  [[nodiscard]] GateState state() const { return machine_.state(); }

 private:
  void check_itself(const Event& event);
  void check_memory();
  void handle(const Event& event);

  const Limits limits_;
  const RobotModel model_{limits_};
  IdSource& ids_;

  // What is known.
  HalLink hal_{limits_};
  ClaimTable claims_;
  PartHistory history_{model_};
  ActingRows rows_{model_, hal_, claims_, history_};
  Outbox outbox_;

  // What watches: the gate itself, parts that have to stop, parts that move.
  SelfMonitor self_{limits_, model_};
  StopMonitor stopping_{limits_, hal_};
  MotionMonitor motion_{model_};
  StateMachine machine_{limits_, ids_, hal_, claims_, history_, stopping_, outbox_};

  // The way of a chunk. Of the ids of verdicts half the range is left to count upwards in.
  ChunkJudge judge_{model_, hal_, rows_};
  Door door_{limits_, hal_,     claims_, history_,
             rows_,   machine_, outbox_, (machine_.new_id() >> 1U) + 1};
  LiveReleases releases_{hal_, claims_, rows_, judge_, door_};
  Candidates candidates_{limits_, hal_, claims_, machine_, judge_, door_, outbox_};

  // What else is said to the gate, and what it says.
  RobotEvents robot_{limits_,  hal_,  claims_, history_,  stopping_,   motion_,
                     machine_, rows_, door_,   releases_, candidates_, outbox_};
  Publisher publisher_{limits_, hal_, claims_, rows_, machine_, outbox_};
  Queries queries_{limits_, hal_,     claims_, history_,   self_,
                   motion_, machine_, robot_,  publisher_, outbox_};
};

void Gate::Core::boot(std::uint64_t now_ns, const BootInfo& info, Outputs& outputs) {
  outbox_.begin_step(now_ns, outputs);
  machine_.boot(info);
  publisher_.finish();
}

// Deadlines first, then the event, then what has to be published.
void Gate::Core::step(std::uint64_t now_ns, const Event& event, Outputs& outputs) {
  outbox_.begin_step(now_ns, outputs);
  if (machine_.is(GateState::boot)) {  // before boot(): status only
    if (event.kind == EventKind::status) queries_.on_status(event.payload);
    return;
  }
  check_itself(event);
  machine_.check_deadlines();
  handle(event);
  publisher_.finish();
}

// G050. A chunk does not wait for memory to be read: the timer's next step does that, 5 ms later
// unless more chunks than the gate can judge keep it busy, and then as soon as it gets its turn.
// In lockstep the world waits for the gate, however long a step takes.
void Gate::Core::check_itself(const Event& event) {
  if (machine_.is_armed() && !hal_.lockstep()) {
    const Evidence slow = check_step_time(limits_, event.previous_step_ns);
    const std::size_t recent = slow.ok() ? 0 : self_.note_overrun(outbox_.now_ns);
    if (recent >= SelfMonitor::overruns_to_stop) {
      machine_.raise_stop(slow);
    } else if (recent != 0) {
      outbox_.count(code::own);
      outbox_.log(phrase(words_of(slow), ": ", recent, " so far"));
    }
  }
  if (event.kind != EventKind::candidate) check_memory();
}

void Gate::Core::check_memory() {
  if (!self_.read_on(outbox_.now_ns, claims_)) return;
  const Evidence changed = self_.find_changed(claims_);
  if (changed.ok()) return;
  if (machine_.is_armed()) return machine_.raise_stop(changed);
  outbox_.count(code::own);
  outbox_.log(words_of(changed));
}

void Gate::Core::handle(const Event& event) {
  switch (event.kind) {
    case EventKind::timer:
      return;
    case EventKind::joint_state:
      return robot_.on_joint_state(event);
    case EventKind::candidate:
      return candidates_.on_candidate(event);
    case EventKind::hal_status:
      return robot_.on_hal_status(event.payload);
    case EventKind::heartbeat:
      return robot_.on_heartbeat(event);
    case EventKind::stop_level:
      return robot_.on_stop_level(event.payload);
    case EventKind::arm:
      return queries_.on_arm(event.payload);
    case EventKind::disarm:
      return queries_.on_disarm(event.payload);
    case EventKind::reset:
      return queries_.on_reset(event.payload);
    case EventKind::claim:
      return queries_.on_claim(event.payload);
    case EventKind::release:
      return queries_.on_release(event.payload);
    case EventKind::status:
      return queries_.on_status(event.payload);
    case EventKind::lease:
      return robot_.on_lease(event.payload);
  }
}

Gate::Gate(const Limits& limits, IdSource& ids) : core_(std::make_unique<Core>(limits, ids)) {}
Gate::~Gate() = default;
void Gate::boot(std::uint64_t now_ns, const BootInfo& info, Outputs& outputs) {
  core_->boot(now_ns, info, outputs);
}
void Gate::step(std::uint64_t now_ns, const Event& event, Outputs& outputs) {
  core_->step(now_ns, event, outputs);
}
GateState Gate::state() const { return core_->state(); }

}  // namespace fairlead
