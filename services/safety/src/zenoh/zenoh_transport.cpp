#include "zenoh/zenoh_transport.hpp"

#include <condition_variable>
#include <deque>
#include <map>
#include <mutex>
#include <thread>
#include <utility>

#include "process/gate_process.hpp"
#include "process/refusal.hpp"
#include "process/thread_handover.hpp"
#include "zenoh/listen_place.hpp"
#include "zenoh/zenoh_values.hpp"

namespace fairlead {
namespace {

// More than any robot has; a bound on what strangers can make the gate declare.
constexpr std::size_t kMaxSources = 64;

thread_local Frame received_frame;
thread_local bool own_lease = false;

z_result_t try_to_open(z_owned_session_t* session, const Endpoints& endpoints) {
  z_owned_config_t config;
  const z_result_t parsed = zc_config_from_str(&config, session_config(endpoints).c_str());
  if (parsed != Z_OK) {
    z_drop(z_move(config));
    check(parsed, "use the endpoints " + endpoints.listen + endpoints.router);
  }
  return z_open(session, z_move(config), nullptr);
}

void open_session(z_owned_session_t* session, const Endpoints& endpoints,
                  const ZenohTransport::OnWait& on_wait) {
  z_result_t opened = try_to_open(session, endpoints);
  while (opened != Z_OK && !endpoints.router.empty()) {
    z_drop(z_move(*session));
    on_wait();
    opened = try_to_open(session, endpoints);
  }
  check(opened, "listen on " + endpoints.listen);
}

struct SourcePublishers {
  SourcePublishers(const z_loaned_session_t* session, const KeyTable& keys, std::string_view source)
      : candidates(session, keys.candidate(source)),
        safe(session, keys.safe(source), "SafeChunk"),
        verdict(session, keys.verdict(source), "Verdict", Qos::hot) {}
  NamedKey candidates;
  SafePublisher safe;
  Publisher verdict;
};

/// One subscription or queryable as its callback sees it.
struct Inlet {
  EventKind kind;
  std::string key;
  const ZenohTransport::Handler* handler;
};

// What the inlet's wildcards stand for in a key: source, person, "source/person"; "**": all of it.
std::string_view source_in(const Inlet& inlet, std::string_view key) {
  const std::size_t begin = inlet.key.find('*');
  if (begin == std::string::npos) return {};
  const std::size_t behind = inlet.key.size() - inlet.key.rfind('*') - 1;
  return key.size() < begin + behind ? key : key.substr(begin, key.size() - begin - behind);
}

std::string_view text_of(const z_loaned_keyexpr_t* key) {
  z_view_string_t view;
  z_keyexpr_as_view_string(key, &view);
  return {z_string_data(z_loan(view)), z_string_len(z_loan(view))};
}

void on_sample(z_loaned_sample_t* sample, void* context) {
  take_over(context);
  const Inlet& inlet = *static_cast<const Inlet*>(context);
  if (z_sample_kind(sample) != Z_SAMPLE_KIND_PUT) return;  // a delete says nothing to the gate
  if (inlet.kind == EventKind::lease && own_lease) return;
  const std::string_view source = source_in(inlet, text_of(z_sample_keyexpr(sample)));
  const std::uint64_t received_ns = monotonic_ns();
  const Bytes payload = received_frame.copy(z_sample_payload(sample));
  (*inlet.handler)({inlet.kind, source, payload, received_ns}, nullptr);
}

void on_query(z_loaned_query_t* query, void* context) {
  take_over(context);
  const Inlet& inlet = *static_cast<const Inlet*>(context);
  const std::uint64_t received_ns = monotonic_ns();
  const std::string_view asked = text_of(z_query_keyexpr(query));
  const std::string_view source = source_in(inlet, asked);
  const std::string key(source.empty() ? std::string_view(inlet.key) : asked);
  QueryAnswer answer(query, key);
  const Bytes payload = received_frame.copy(z_query_payload(query));
  (*inlet.handler)({inlet.kind, source, payload, received_ns}, &answer);
}

/// Set by a callback, waited for by the main thread.
struct Heard {
  std::mutex mutex;
  std::condition_variable changed;
  bool yes = false;
};

void on_lease(z_loaned_sample_t*, void* context) {
  take_over(context);
  Heard& heard = *static_cast<Heard*>(context);
  const std::lock_guard lock(heard.mutex);
  heard.yes = true;
  heard.changed.notify_one();
}

}  // namespace

class ZenohTransport::Session {
 public:
  Session(const Endpoints& endpoints, KeyTable keys, const OnWait& on_wait)
      : keys_(std::move(keys)),
        session_([&](z_owned_session_t* out) { open_session(out, endpoints, on_wait); }),
        lease_(get(), keys_.lease(), "Lease", Qos::hot),
        status_(get(), keys_.gate_status(), "GateStatus", Qos::status) {}

  const z_loaned_session_t* get() { return z_loan(session_.value()); }

  bool hears_another_gate(std::chrono::milliseconds patience) {
    Heard heard;
    hand_over(&heard);
    const Owned<z_owned_subscriber_t> subscriber([&](z_owned_subscriber_t* out) {
      z_owned_closure_sample_t callback;
      z_closure_sample(&callback, on_lease, nullptr, &heard);
      check(
          z_declare_subscriber(get(), out, KeyView(keys_.lease()).get(), z_move(callback), nullptr),
          "subscribe to " + keys_.lease());
    });
    std::unique_lock lock(heard.mutex);
    return heard.changed.wait_for(lock, patience, [&heard] { return heard.yes; });
  }

  void listen(Handler handler) {
    handler_ = std::move(handler);
    subscribe(EventKind::joint_state, keys_.joints());
    subscribe(EventKind::candidate, keys_.every_candidate());
    subscribe(EventKind::hal_status, keys_.hal_status());
    subscribe(EventKind::heartbeat, keys_.every_heartbeat());
    subscribe(EventKind::stop_level, keys_.stop());
    subscribe(EventKind::lease, keys_.lease());
    answer_commands(EventKind::arm, "arm");
    answer_commands(EventKind::disarm, "disarm");
    answer_commands(EventKind::reset, "reset");
    answer(EventKind::claim, keys_.every_claim());
    answer(EventKind::claim, keys_.every_claim_of_any());
    answer(EventKind::release, keys_.every_release());
    answer(EventKind::status, keys_.gate_status());
  }

  void stop_listening() {
    queryables_.clear();
    subscribers_.clear();
  }

  void announce(const std::string& service) {
    token_ =
        std::make_unique<Owned<z_owned_liveliness_token_t>>([&](z_owned_liveliness_token_t* out) {
          const std::string key = keys_.alive(service);
          check(z_liveliness_declare_token(get(), out, KeyView(key).get(), nullptr),
                "declare " + key);
        });
  }

  bool prepare_source(std::string_view source, bool& is_new) {
    is_new = false;
    if (!is_key_chunk(source)) return false;
    {
      const std::lock_guard lock(sources_mutex_);
      if (sources_.contains(source)) return true;
      if (sources_.size() >= kMaxSources) return false;
    }
    // Declared without the lock: a declaration may take Zenoh's own locks.
    auto publishers = std::make_shared<SourcePublishers>(get(), keys_, source);
    const std::lock_guard lock(sources_mutex_);
    sources_.try_emplace(std::string(source), std::move(publishers));
    is_new = true;
    return true;
  }

  void forget_source(std::string_view source) {
    std::shared_ptr<SourcePublishers> unused;
    {
      const std::lock_guard lock(sources_mutex_);
      const auto found = sources_.find(source);
      if (found == sources_.end()) return;
      unused = std::move(found->second);
      sources_.erase(found);
    }
    // Undeclared here, where no lock is held: it waits for what its subscriber calls. A step that
    // puts a verdict with it may be such a call, and has to be done first.
    while (unused.use_count() > 1) std::this_thread::yield();
  }

  void publish(OutputKind kind, const Name& source, Bytes payload, Leaves when) {
    if (kind == OutputKind::lease) {
      own_lease = true;  // comes back to this session's own subscription, within `put`
      lease_.put(payload);
      own_lease = false;
    } else if (kind == OutputKind::status) {
      status_.put(payload);
    } else if (const auto publishers = publishers_of(source.view()); publishers != nullptr) {
      if (kind == OutputKind::safe_chunk)
        publishers->safe.put(payload, when);
      else
        publishers->verdict.put(payload);
    }
  }

 private:
  // Shared: it may be forgotten while a verdict for a stranger is being put.
  std::shared_ptr<SourcePublishers> publishers_of(std::string_view source) {
    const std::lock_guard lock(sources_mutex_);
    const auto found = sources_.find(source);
    return found == sources_.end() ? nullptr : found->second;
  }

  Inlet& add_inlet(EventKind kind, std::string key) {
    Inlet& inlet = inlets_.emplace_back(Inlet{kind, std::move(key), &handler_});
    hand_over(&inlet);
    return inlet;
  }

  void subscribe(EventKind kind, const std::string& key) {
    Inlet& inlet = add_inlet(kind, key);
    subscribers_.emplace_back([&](z_owned_subscriber_t* out) {
      z_owned_closure_sample_t callback;
      z_closure_sample(&callback, on_sample, nullptr, &inlet);
      check(z_declare_subscriber(get(), out, KeyView(key).get(), z_move(callback), nullptr),
            "subscribe to " + key);
    });
  }

  void answer(EventKind kind, const std::string& key) {
    Inlet& inlet = add_inlet(kind, key);
    queryables_.emplace_back([&](z_owned_queryable_t* out) {
      z_owned_closure_query_t callback;
      z_closure_query(&callback, on_query, nullptr, &inlet);
      check(z_declare_queryable(get(), out, KeyView(key).get(), z_move(callback), nullptr),
            "answer " + key);
    });
  }

  // On the key that says nothing of who asks, and on each person's own.
  void answer_commands(EventKind kind, std::string_view verb) {
    answer(kind, keys_.gate_command(verb));
    answer(kind, keys_.gate_command_of_any(verb));
  }

  // Members are destroyed from the last to the first: listeners, then publishers, then session.
  KeyTable keys_;
  Handler handler_;
  std::deque<Inlet> inlets_;
  Owned<z_owned_session_t> session_;
  Publisher lease_;
  Publisher status_;
  std::mutex sources_mutex_;
  std::map<std::string, std::shared_ptr<SourcePublishers>, std::less<>> sources_;
  std::deque<Owned<z_owned_subscriber_t>> subscribers_;
  std::deque<Owned<z_owned_queryable_t>> queryables_;
  std::unique_ptr<Owned<z_owned_liveliness_token_t>> token_;
};

ZenohTransport::ZenohTransport(const Endpoints& endpoints, KeyTable keys, const OnWait& on_wait) {
  prepare_runtime(endpoints);
  zc_init_log_from_env_or("error");
  check_listen_place(endpoints.listen);
  session_ = std::make_unique<Session>(endpoints, std::move(keys), on_wait);
}

ZenohTransport::~ZenohTransport() = default;

bool ZenohTransport::hears_another_gate(std::chrono::milliseconds patience) {
  return session_->hears_another_gate(patience);
}

void ZenohTransport::listen(Handler handler) { session_->listen(std::move(handler)); }

void ZenohTransport::announce(const std::string& service) { session_->announce(service); }

void ZenohTransport::stop_listening() { session_->stop_listening(); }

bool ZenohTransport::prepare_source(std::string_view source, bool& is_new) {
  return session_->prepare_source(source, is_new);
}

void ZenohTransport::forget_source(std::string_view source) { session_->forget_source(source); }

void ZenohTransport::publish(OutputKind kind, const Name& source, Bytes payload, Leaves when) {
  session_->publish(kind, source, payload, when);
}

}  // namespace fairlead
