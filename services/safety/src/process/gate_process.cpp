#include "process/gate_process.hpp"

#include <sys/random.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iterator>

#include "config/sha256.hpp"
#include "fairlead_safety/codec.hpp"
#include "fairlead_safety/query_messages.hpp"
#include "process/foreign_name.hpp"
#include "process/verdict_text.hpp"

namespace fairlead {
namespace {

// Well under the shortest promise the timer serves, a lease every 25 ms.
constexpr auto kTimerPeriod = std::chrono::milliseconds(5);

// Sources that are ready to be told their verdicts; half of what the network side keeps at most.
constexpr std::size_t kServedSources = 32;

/// Ids that nobody can guess or repeat, from the system's entropy. Without any the gate cannot
/// tell an old command from a new one: it ends, and the robot holds.
class RandomIds final : public IdSource {
 public:
  std::uint64_t next_id() override {
    std::uint64_t id = 0;
    if (::getrandom(&id, sizeof id, 0) == sizeof id) return id;
    std::fputs("ERROR fairlead-safety: the system gives no random numbers\n", stderr);
    std::abort();
  }
};

std::string_view text_of(Bytes payload) {
  return {reinterpret_cast<const char*>(payload.data()), payload.size()};
}

Hash hash_of_file(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  const std::string text{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  return sha256(Bytes(reinterpret_cast<const std::uint8_t*>(text.data()), text.size()));
}

// A SafeChunk leaves in one piece with the lease of its step, which is on every link that it is on.
// Nothing rides with a verdict: that goes to a source's own link.
Leaves when_leaves(bool before_lease) { return before_lease ? Leaves::with_next : Leaves::now; }

bool is_lease(const Output& output) { return output.kind == OutputKind::lease; }

}  // namespace

std::uint64_t monotonic_ns() {
  return static_cast<std::uint64_t>(std::chrono::duration_cast<std::chrono::nanoseconds>(
                                        std::chrono::steady_clock::now().time_since_epoch())
                                        .count());
}

GateProcess::GateProcess(const Limits& limits, std::string config_file, LatchStore& store,
                         LogWriter& log, DecisionLog& decisions, Outlet& outlet,
                         ServiceManager& manager)
    : limits_(limits),
      config_file_(std::move(config_file)),
      store_(store),
      log_(log),
      decisions_(decisions),
      outlet_(outlet),
      manager_(manager),
      random_ids_(std::make_unique<RandomIds>()),
      ids_(*random_ids_),
      gate_(limits, ids_) {}

GateProcess::~GateProcess() { shut_down(); }

void GateProcess::start(bool new_state) {
  {
    const std::lock_guard lock(mutex_);
    const StoredState& found = store_.found();
    const BootInfo info{store_.first_start(), found.clean_mark, Bytes(found.latch), new_state};
    const std::uint64_t now_ns = monotonic_ns();
    gate_.boot(now_ns, info, *outputs_);
    carry_out(nullptr);
    decisions_.boot(now_ns, info, ids_, *outputs_);
  }
  timer_ = std::thread([this] { run_timer(); });
}

void GateProcess::handle(const Event& event, Answer* answer) {
  if (event.kind == EventKind::candidate && !intake_.admits(event)) return;
  if (const std::string foreign = foreign_name(event); !foreign.empty())
    return refuse(answer, foreign.c_str(), "ask on the key of whoever asks");
  if (event.kind == EventKind::arm && !prepare_to_arm(answer)) return;
  if (event.kind == EventKind::claim) return handle_claim(event, answer);
  const std::lock_guard lock(mutex_);
  if (event.kind == EventKind::arm) step(Event{}, nullptr);  // due first: disarm when idle
  const bool may_arm = event.kind == EventKind::arm && gate_.state() == GateState::disarmed;
  if (may_arm && store_.is_marked())
    return refuse(answer, "somebody disarmed or reset it meanwhile", "fairlead arm");
  step(event, answer);
  if (may_arm && gate_.state() == GateState::disarmed) store_.set_clean_mark(true);  // refused
}

// Motion may follow an arm at once, so the clean mark must be gone from the disk before it.
bool GateProcess::prepare_to_arm(Answer* answer) {
  {
    const std::lock_guard lock(mutex_);
    if (gate_.state() != GateState::disarmed) return true;  // the core refuses, with its reason
  }
  if (hash_of_file(config_file_) != limits_.config_hash) {
    refuse(answer, "the configuration file has changed since the gate read it",
           "fairlead restart safety; fairlead restart hal");
    return false;
  }
  const std::string fault = store_.clear_clean_mark_now();
  if (!fault.empty()) refuse(answer, fault.c_str(), "make the gate's state folder writable");
  return fault.empty();
}

// The source's publishers are there before its claim is; a claim that the core refuses leaves
// none behind, so that strangers cannot use them up.
void GateProcess::handle_claim(const Event& event, Answer* answer) {
  const std::lock_guard one_claim(claims_mutex_);
  Claim claim;
  // A frame that does not decode is the core's to refuse, with its reason.
  const bool readable = decode(event.payload, claim) == FrameFault::none;
  bool is_new = false;
  if (readable) make_room();
  if (readable && !outlet_.prepare_source(claim.source.view(), is_new)) {
    refuse(answer, "the source cannot be in a key, or this gate has served too many sources",
           "use 1 to 64 of a-z 0-9 _ . -, or: fairlead restart safety");
    return;
  }
  {
    const std::lock_guard lock(mutex_);
    step(event, answer);
    if (!was_refused()) {
      is_new = false;
      note_granted(claim);
    }
  }
  if (is_new) outlet_.forget_source(claim.source.view());
}

// Of the sources that hold no claim any more the first served is forgotten.
void GateProcess::make_room() {
  if (served_.size() < kServedSources) return;
  const auto idle = std::ranges::find_if(served_, [this](const std::string& source) {
    const std::lock_guard lock(mutex_);
    return !is_granted(source);
  });
  if (idle == served_.end()) return;
  outlet_.forget_source(*idle);
  intake_.forget(*idle);
  served_.erase(idle);
}

bool GateProcess::is_granted(std::string_view source) const {
  Lease lease;
  if (decode(Bytes(newest_lease_), lease) != FrameFault::none) return true;  // nobody knows
  return std::ranges::any_of(lease.grants,
                             [&](const Grant& grant) { return grant.source == source; });
}

void GateProcess::note_granted(const Claim& claim) {
  const std::string source(claim.source.view());
  std::erase(served_, source);
  served_.push_back(source);
  Lease lease;
  (void)decode(Bytes(newest_lease_), lease);
  for (const Output& output : outputs_->items()) {
    ClaimReply reply;
    if (output.kind == OutputKind::reply &&
        decode(outputs_->payload(output), reply) == FrameFault::none)
      intake_.expect(source, reply.session, reply.epoch, reply.claim_id, lease.grants);
  }
}

bool GateProcess::was_refused() const {
  return std::ranges::any_of(
      outputs_->items(), [](const Output& output) { return output.kind == OutputKind::refusal; });
}

void GateProcess::refuse(Answer* answer, const char* reason, const char* fix) {
  log_.write(LogWriter::Kind::refusal, std::string("refused a query: ") + reason);
  std::array<std::uint8_t, 1024> buffer{};
  const Refusal refusal{"safety", reason, fix};
  if (answer != nullptr) answer->refuse(Bytes(buffer).first(encode(refusal, buffer)));
}

void GateProcess::step(const Event& event, Answer* answer) {
  const std::uint64_t now_ns = monotonic_ns();
  Event timed = event;
  timed.previous_step_ns = previous_step_ns_;
  gate_.step(now_ns, timed, *outputs_);
  carry_out(answer);
  previous_step_ns_ =
      static_cast<std::uint32_t>(std::min<std::uint64_t>(monotonic_ns() - now_ns, UINT32_MAX));
  decisions_.step(now_ns, timed, ids_, *outputs_);  // last: nothing waits for the log
}

void GateProcess::carry_out(Answer* answer) {
  auto leases_left = static_cast<std::size_t>(std::ranges::count_if(outputs_->items(), is_lease));
  for (const Output& output : outputs_->items()) {
    const Bytes payload = outputs_->payload(output);
    if (is_lease(output)) {
      --leases_left;
      newest_lease_.assign(payload.begin(), payload.end());
    }
    switch (output.kind) {
      case OutputKind::verdict:
        outlet_.publish(output.kind, output.source, payload, Leaves::now);
        log_refusal(payload);
        break;
      case OutputKind::safe_chunk:
        outlet_.publish(output.kind, output.source, payload, when_leaves(leases_left > 0));
        break;
      case OutputKind::lease:
      case OutputKind::status:
        outlet_.publish(output.kind, output.source, payload, Leaves::now);
        break;
      case OutputKind::reply:
        if (answer != nullptr) answer->reply(payload);
        break;
      case OutputKind::refusal:
        if (answer != nullptr) answer->refuse(payload);
        break;
      case OutputKind::persist_latch:
        store_.set_latch(payload);
        break;
      case OutputKind::clear_latch:
        store_.set_latch(Bytes());
        break;
      case OutputKind::write_clean_mark:
        store_.set_clean_mark(true);
        break;
      case OutputKind::clear_clean_mark:
        store_.set_clean_mark(false);
        break;
      case OutputKind::log:
        log_.info(text_of(payload));
        break;
    }
  }
  if (outputs_->overflowed()) log_.warning("outputs of one step did not fit; some were not sent");
}

void GateProcess::log_refusal(Bytes payload) {
  Verdict verdict;
  if (decode(payload, verdict) != FrameFault::none || verdict.code == 0) return;
  if (verdict.verdict_id <= logged_verdict_) return;  // said again for who missed it
  logged_verdict_ = verdict.verdict_id;
  log_.write(LogWriter::Kind::refusal, verdict_text(verdict));
}

void GateProcess::say_left_out() {
  const std::uint64_t now_ns = monotonic_ns();
  if (now_ns - said_left_out_ns_ < 1'000'000'000) return;  // once a second at most
  said_left_out_ns_ = now_ns;
  if (const Intake::LeftOut out = intake_.take_left_out(); out.sum() != 0)
    log_.warning("candidates left out unread: " + std::to_string(out.strangers) +
                 " that cite no live claim, " + std::to_string(out.copies) + " copies, " +
                 std::to_string(out.excess) + " beyond what one claim may send");
}

void GateProcess::run_timer() {
  std::unique_lock lock(mutex_);
  auto next = std::chrono::steady_clock::now() + kTimerPeriod;
  while (!stop_timer_.wait_until(lock, next, [this] { return stopping_; })) {
    step(Event{}, nullptr);
    say_left_out();
    manager_.say_alive(monotonic_ns());
    // After a suspension the missed turns are not made up for.
    next = std::max(next, std::chrono::steady_clock::now() - kTimerPeriod) + kTimerPeriod;
  }
}

void GateProcess::shut_down() {
  {
    const std::lock_guard lock(mutex_);
    if (stopping_) return;
    stopping_ = true;
  }
  stop_timer_.notify_one();
  if (timer_.joinable()) timer_.join();
  std::array<std::uint8_t, 64> buffer{};
  const Disarm disarm{"the gate's shutdown"};
  Event event;
  event.kind = EventKind::disarm;
  event.payload = Bytes(buffer).first(encode(disarm, buffer));
  event.received_ns = monotonic_ns();
  const std::lock_guard lock(mutex_);
  step(event, nullptr);
}

}  // namespace fairlead
