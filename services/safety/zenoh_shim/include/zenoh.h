// The subset of the zenoh-c API that the safety gate uses, same names and conventions.
//
// Own writing; source-compatible with the official header, not binary-compatible with its
// library. The gate is C++ only, so this header is too.
//
//   z_owned_X_t   a value you own; ends with z_drop(z_move(x)), twice is a no-op
//   z_loaned_X_t  a borrowed value, from z_loan(x) or from a callback's argument
//   z_moved_X_t   a value given away, from z_move(x)
//   z_view_X_t    looks at somebody else's text; no drop
//
// Functions return Z_OK or a negative z_result_t; a failed call leaves its owned output safe
// to drop. Options that are not declared here must be NULL. Callbacks run on the receive
// threads, several at once; dropping a subscriber, queryable or session waits for them.
#pragma once

#include <cstddef>
#include <cstdint>

extern "C" {

typedef int8_t z_result_t;
#define Z_OK 0
#define Z_EINVAL -1
#define Z_EPARSE -2
#define Z_ENETWORK -4
#define Z_ENULL -5
#define Z_EGENERIC INT8_MIN

typedef enum z_sample_kind_t : int32_t {
  Z_SAMPLE_KIND_PUT = 0,
  Z_SAMPLE_KIND_DELETE = 1
} z_sample_kind_t;

typedef enum z_congestion_control_t : int32_t {
  Z_CONGESTION_CONTROL_BLOCK = 0,
  Z_CONGESTION_CONTROL_DROP = 1,
} z_congestion_control_t;

typedef enum z_priority_t : int32_t {
  Z_PRIORITY_REAL_TIME = 1,
  Z_PRIORITY_INTERACTIVE_HIGH = 2,
  Z_PRIORITY_INTERACTIVE_LOW = 3,
  Z_PRIORITY_DATA_HIGH = 4,
  Z_PRIORITY_DATA = 5,
  Z_PRIORITY_DATA_LOW = 6,
  Z_PRIORITY_BACKGROUND = 7,
} z_priority_t;

// A boxed value: one pointer, null once dropped or moved out.
#define FAIRLEAD_ZENOH_BOXED(name)                        \
  typedef struct z_loaned_##name##_t z_loaned_##name##_t; \
  typedef struct z_owned_##name##_t {                     \
    void* _value;                                         \
  } z_owned_##name##_t;                                   \
  typedef struct z_moved_##name##_t {                     \
    z_owned_##name##_t _this;                             \
  } z_moved_##name##_t;                                   \
  void z_##name##_drop(z_moved_##name##_t* this_);

FAIRLEAD_ZENOH_BOXED(config)
FAIRLEAD_ZENOH_BOXED(session)
FAIRLEAD_ZENOH_BOXED(publisher)
FAIRLEAD_ZENOH_BOXED(subscriber)
FAIRLEAD_ZENOH_BOXED(queryable)
FAIRLEAD_ZENOH_BOXED(liveliness_token)
FAIRLEAD_ZENOH_BOXED(encoding)
#undef FAIRLEAD_ZENOH_BOXED

typedef struct z_loaned_keyexpr_t z_loaned_keyexpr_t;
typedef struct z_loaned_bytes_t z_loaned_bytes_t;
typedef struct z_loaned_sample_t z_loaned_sample_t;
typedef struct z_loaned_query_t z_loaned_query_t;

typedef struct z_owned_bytes_t {
  uint64_t _storage[8];
} z_owned_bytes_t;
typedef struct z_moved_bytes_t {
  z_owned_bytes_t _this;
} z_moved_bytes_t;
typedef struct z_bytes_reader_t {
  const z_loaned_bytes_t* _bytes;
  size_t _position;
} z_bytes_reader_t;

typedef struct z_view_keyexpr_t {
  uint64_t _storage[6];
} z_view_keyexpr_t;
typedef struct z_loaned_string_t {
  const char* _data;
  size_t _len;
} z_loaned_string_t;
typedef struct z_view_string_t {
  z_loaned_string_t _this;
} z_view_string_t;

typedef struct z_owned_closure_sample_t {
  void* _context;
  void (*_call)(z_loaned_sample_t* sample, void* context);
  void (*_drop)(void* context);
} z_owned_closure_sample_t;
typedef struct z_moved_closure_sample_t {
  z_owned_closure_sample_t _this;
} z_moved_closure_sample_t;
typedef struct z_owned_closure_query_t {
  void* _context;
  void (*_call)(z_loaned_query_t* query, void* context);
  void (*_drop)(void* context);
} z_owned_closure_query_t;
typedef struct z_moved_closure_query_t {
  z_owned_closure_query_t _this;
} z_moved_closure_query_t;

// Start from z_publisher_options_default: drop on congestion, data priority, not express.
typedef struct z_publisher_options_t {
  z_moved_encoding_t* encoding;
  z_congestion_control_t congestion_control;
  z_priority_t priority;
  bool is_express;
} z_publisher_options_t;

typedef struct z_open_options_t z_open_options_t;
typedef struct z_publisher_put_options_t z_publisher_put_options_t;
typedef struct z_subscriber_options_t z_subscriber_options_t;
typedef struct z_queryable_options_t z_queryable_options_t;
typedef struct z_query_reply_options_t z_query_reply_options_t;
typedef struct z_query_reply_err_options_t z_query_reply_err_options_t;
typedef struct z_liveliness_token_options_t z_liveliness_token_options_t;

// --- log, configuration, session ---

// RUST_LOG overrides `fallback_filter`, which must not be NULL; logs go to stdout.
z_result_t zc_init_log_from_env_or(const char* fallback_filter);
z_result_t zc_config_from_str(z_owned_config_t* this_, const char* json5);
z_result_t z_open(z_owned_session_t* this_, z_moved_config_t* config,
                  const z_open_options_t* options);
const z_loaned_session_t* z_session_loan(const z_owned_session_t* this_);
z_result_t z_liveliness_declare_token(const z_loaned_session_t* session,
                                      z_owned_liveliness_token_t* token,
                                      const z_loaned_keyexpr_t* key,
                                      const z_liveliness_token_options_t* options);

// --- keys ---

// The view aliases `expr` until the declare call that uses it has returned.
z_result_t z_view_keyexpr_from_str(z_view_keyexpr_t* this_, const char* expr);
const z_loaned_keyexpr_t* z_view_keyexpr_loan(const z_view_keyexpr_t* this_);
void z_keyexpr_as_view_string(const z_loaned_keyexpr_t* this_, z_view_string_t* out);
const z_loaned_string_t* z_view_string_loan(const z_view_string_t* this_);
const char* z_string_data(const z_loaned_string_t* this_);  // not NUL-terminated
size_t z_string_len(const z_loaned_string_t* this_);

// --- payloads ---

z_result_t z_bytes_copy_from_buf(z_owned_bytes_t* this_, const uint8_t* data, size_t len);
void z_bytes_drop(z_moved_bytes_t* this_);
const z_loaned_bytes_t* z_bytes_loan(const z_owned_bytes_t* this_);
size_t z_bytes_len(const z_loaned_bytes_t* this_);
z_bytes_reader_t z_bytes_get_reader(const z_loaned_bytes_t* data);
size_t z_bytes_reader_read(z_bytes_reader_t* this_, uint8_t* dst, size_t len);

// --- publish ---

z_result_t z_encoding_from_str(z_owned_encoding_t* this_, const char* text);
void z_publisher_options_default(z_publisher_options_t* this_);
z_result_t z_declare_publisher(const z_loaned_session_t* session, z_owned_publisher_t* publisher,
                               const z_loaned_keyexpr_t* key, z_publisher_options_t* options);
const z_loaned_publisher_t* z_publisher_loan(const z_owned_publisher_t* this_);
z_result_t z_publisher_put(const z_loaned_publisher_t* this_, z_moved_bytes_t* payload,
                           const z_publisher_put_options_t* options);

// --- subscribe ---

void z_closure_sample(z_owned_closure_sample_t* this_,
                      void (*call)(z_loaned_sample_t* sample, void* context),
                      void (*drop)(void* context), void* context);
void z_closure_sample_drop(z_moved_closure_sample_t* this_);
z_result_t z_declare_subscriber(const z_loaned_session_t* session, z_owned_subscriber_t* subscriber,
                                const z_loaned_keyexpr_t* key, z_moved_closure_sample_t* callback,
                                const z_subscriber_options_t* options);
const z_loaned_bytes_t* z_sample_payload(const z_loaned_sample_t* this_);
const z_loaned_keyexpr_t* z_sample_keyexpr(const z_loaned_sample_t* this_);
z_sample_kind_t z_sample_kind(const z_loaned_sample_t* this_);

// --- answer queries ---

void z_closure_query(z_owned_closure_query_t* this_,
                     void (*call)(z_loaned_query_t* query, void* context),
                     void (*drop)(void* context), void* context);
void z_closure_query_drop(z_moved_closure_query_t* this_);
z_result_t z_declare_queryable(const z_loaned_session_t* session, z_owned_queryable_t* queryable,
                               const z_loaned_keyexpr_t* key, z_moved_closure_query_t* callback,
                               const z_queryable_options_t* options);
const z_loaned_keyexpr_t* z_query_keyexpr(const z_loaned_query_t* this_);
const z_loaned_bytes_t* z_query_payload(const z_loaned_query_t* this_);  // NULL if there is none
// The query's own key may be a wildcard; a reply's is none.
z_result_t z_query_reply(const z_loaned_query_t* this_, const z_loaned_keyexpr_t* key,
                         z_moved_bytes_t* payload, const z_query_reply_options_t* options);
z_result_t z_query_reply_err(const z_loaned_query_t* this_, z_moved_bytes_t* payload,
                             const z_query_reply_err_options_t* options);

}  // extern "C"

inline const z_loaned_session_t* z_loan(const z_owned_session_t& x) { return z_session_loan(&x); }
inline const z_loaned_publisher_t* z_loan(const z_owned_publisher_t& x) {
  return z_publisher_loan(&x);
}
inline const z_loaned_bytes_t* z_loan(const z_owned_bytes_t& x) { return z_bytes_loan(&x); }
inline const z_loaned_keyexpr_t* z_loan(const z_view_keyexpr_t& x) {
  return z_view_keyexpr_loan(&x);
}
inline const z_loaned_string_t* z_loan(const z_view_string_t& x) { return z_view_string_loan(&x); }

#define FAIRLEAD_ZENOH_MOVE(name)                            \
  inline z_moved_##name##_t* z_move(z_owned_##name##_t& x) { \
    return reinterpret_cast<z_moved_##name##_t*>(&x);        \
  }                                                          \
  inline void z_drop(z_moved_##name##_t* x) { z_##name##_drop(x); }

FAIRLEAD_ZENOH_MOVE(config)
FAIRLEAD_ZENOH_MOVE(session)
FAIRLEAD_ZENOH_MOVE(publisher)
FAIRLEAD_ZENOH_MOVE(subscriber)
FAIRLEAD_ZENOH_MOVE(queryable)
FAIRLEAD_ZENOH_MOVE(liveliness_token)
FAIRLEAD_ZENOH_MOVE(encoding)
FAIRLEAD_ZENOH_MOVE(bytes)
FAIRLEAD_ZENOH_MOVE(closure_sample)
FAIRLEAD_ZENOH_MOVE(closure_query)
#undef FAIRLEAD_ZENOH_MOVE
