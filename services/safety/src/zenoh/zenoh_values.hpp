// zenoh-c values as C++ ones: they drop themselves, and a failed call throws. Only for
// zenoh_transport.cpp.
#pragma once

#include <zenoh.h>

#include <algorithm>
#include <array>
#include <string>

#include "fairlead_safety/limits.hpp"
#include "process/outlet.hpp"
#include "process/refusal.hpp"

namespace fairlead {

inline void check(z_result_t result, const std::string& what) {
  if (result != Z_OK) {
    throw StartFailed("zenoh: cannot " + what + " (error " + std::to_string(result) + ")");
  }
}

/// A Zenoh value that drops itself. `fill` is the call that makes it; it must always write it.
template <class T>
class Owned {
 public:
  template <class Fill>
  explicit Owned(Fill fill) {
    fill(&value_);
  }
  ~Owned() { z_drop(z_move(value_)); }
  Owned(const Owned&) = delete;
  Owned& operator=(const Owned&) = delete;
  T& value() { return value_; }

 private:
  T value_;
};

class KeyView {
 public:
  explicit KeyView(const std::string& key) {
    check(z_view_keyexpr_from_str(&view_, key.c_str()), "use the key " + key);
  }
  const z_loaned_keyexpr_t* get() const { return z_loan(view_); }

 private:
  z_view_keyexpr_t view_;
};

/// A key that a subscriber names, beside the wildcard that handles its messages. Zenoh numbers it
/// and looks up once who may write and read it. On a key that only a wildcard matches it spells the
/// key out and asks all rules at each message.
class NamedKey {
 public:
  NamedKey(const z_loaned_session_t* session, const std::string& key)
      : subscriber_([&](z_owned_subscriber_t* out) {
          z_owned_closure_sample_t nothing;
          z_closure_sample(&nothing, [](z_loaned_sample_t*, void*) {}, nullptr, nullptr);
          check(z_declare_subscriber(session, out, KeyView(key).get(), z_move(nothing), nullptr),
                "subscribe to " + key);
        }) {}

 private:
  Owned<z_owned_subscriber_t> subscriber_;
};

/// Copies a payload where it is one run of bytes. One byte more than the largest frame is
/// kept, so that the core sees an oversized one as oversized.
class Frame {
 public:
  Bytes copy(const z_loaned_bytes_t* payload) {
    if (payload == nullptr) return {};
    z_bytes_reader_t reader = z_bytes_get_reader(payload);
    return Bytes(bytes_).first(z_bytes_reader_read(&reader, bytes_.data(), bytes_.size()));
  }

 private:
  std::array<std::uint8_t, max_frame_bytes + 1> bytes_;
};

/// `hot_with_next`: as `hot`, but not express: it leaves with the express one that follows.
enum class Qos { hot, hot_with_next, status };

/// One declared key: dropped on congestion, so that a put never blocks.
class Publisher {
 public:
  Publisher(const z_loaned_session_t* session, const std::string& key, const char* type, Qos qos)
      : publisher_([&](z_owned_publisher_t* out) {
          z_publisher_options_t options;
          z_publisher_options_default(&options);
          z_owned_encoding_t encoding;
          const std::string name = std::string("application/msgpack;fairlead.") + type + ".v1";
          check(z_encoding_from_str(&encoding, name.c_str()), "use the encoding " + name);
          options.encoding = z_move(encoding);
          options.congestion_control = Z_CONGESTION_CONTROL_DROP;
          if (qos != Qos::status) options.priority = Z_PRIORITY_REAL_TIME;
          options.is_express = qos == Qos::hot;
          check(z_declare_publisher(session, out, KeyView(key).get(), &options), "publish " + key);
        }) {}

  void put(Bytes payload) {
    z_owned_bytes_t bytes;
    z_bytes_copy_from_buf(&bytes, payload.data(), payload.size());
    z_publisher_put(z_loan(publisher_.value()), z_move(bytes), nullptr);
  }

 private:
  Owned<z_owned_publisher_t> publisher_;
};

/// A key of SafeChunks. One leaves in one piece with the lease that follows it: one sending, and
/// the HAL wakes once. Whether a message is express is part of its publisher, so there are two.
class SafePublisher {
 public:
  SafePublisher(const z_loaned_session_t* session, const std::string& key, const char* type)
      : now_(session, key, type, Qos::hot), with_next_(session, key, type, Qos::hot_with_next) {}

  void put(Bytes payload, Leaves when) { (when == Leaves::now ? now_ : with_next_).put(payload); }

 private:
  Publisher now_;
  Publisher with_next_;
};

/// Answers on the queryable's own key, for the query's may be a wildcard; or on the query's, which
/// names a source.
class QueryAnswer final : public Answer {
 public:
  QueryAnswer(const z_loaned_query_t* query, const std::string& key) : query_(query), key_(key) {}
  ~QueryAnswer() override {
    if (!answered_) refuse({});  // an error reply beats a query that times out
  }
  void reply(Bytes payload) override {
    z_owned_bytes_t bytes;
    z_bytes_copy_from_buf(&bytes, payload.data(), payload.size());
    z_query_reply(query_, KeyView(key_).get(), z_move(bytes), nullptr);
    answered_ = true;
  }
  void refuse(Bytes payload) override {
    z_owned_bytes_t bytes;
    z_bytes_copy_from_buf(&bytes, payload.data(), payload.size());
    z_query_reply_err(query_, z_move(bytes), nullptr);
    answered_ = true;
  }

 private:
  const z_loaned_query_t* query_;
  const std::string& key_;
  bool answered_ = false;
};

}  // namespace fairlead
