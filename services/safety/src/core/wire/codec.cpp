#include <bit>
#include <limits>
#include <tuple>

#include "core/wire/msgpack.hpp"
#include "core/wire/phrase.hpp"
#include "fairlead_safety/codec.hpp"
#include "fairlead_safety/query_messages.hpp"

namespace fairlead {
namespace {

static_assert(std::endian::native == std::endian::little,
              "number blocks are little-endian on the wire");
static_assert(std::numeric_limits<double>::is_iec559 && sizeof(double) == 8);

constexpr std::uint64_t wire_version = 1;

// --- reading: one overload per type of field -----------------------------------------

void read(Reader& in, std::uint64_t& value) { value = in.unsigned_number(UINT64_MAX); }
void read(Reader& in, std::uint32_t& value) {
  value = static_cast<std::uint32_t>(in.unsigned_number(UINT32_MAX));
}
void read(Reader& in, std::uint8_t& value) {
  value = static_cast<std::uint8_t>(in.unsigned_number(UINT8_MAX));
}
void read(Reader& in, std::int64_t& value) { value = in.signed_number(); }
void read(Reader& in, double& value) { value = in.number(); }
void read(Reader& in, bool& value) { value = in.boolean(); }
// For people: nothing that a log or a terminal would obey.
void read(Reader& in, Text& value) {
  value.clear();
  append_printable(value, in.text());
}

void read(Reader& in, Name& value) {
  const std::string_view text = in.text();
  if (text.size() > Name::capacity) in.fail(FrameFault::capacity);
  if (has_control(text)) in.fail(FrameFault::text);
  value = Name(text);
}

void read(Reader& in, NumberView& value) {
  const Bytes bytes = in.binary();
  if (bytes.size() % sizeof(double) != 0) in.fail(FrameFault::wrong_type);
  value = NumberView(in.ok() ? bytes : Bytes());
}

template <std::size_t N>
void read(Reader& in, std::array<std::uint8_t, N>& value) {
  const Bytes bytes = in.binary();
  if (bytes.size() != N) in.fail(FrameFault::wrong_type);
  if (in.ok()) std::memcpy(value.data(), bytes.data(), N);
}

template <class Record>
auto read(Reader& in, Record& record) -> decltype(record.fields(), void());

template <class T, std::size_t N>
void read(Reader& in, FixedVec<T, N>& list) {
  const std::size_t count = in.array();
  if (!list.resize(count)) in.fail(FrameFault::capacity);
  for (T& item : list) {
    if (!in.ok()) return;
    read(in, item);
  }
}

template <class Tuple>
void read_each(Reader& in, Tuple&& fields) {
  std::apply([&in](auto&... field) { (read(in, field), ...); }, fields);
}

template <class Record>
auto read(Reader& in, Record& record) -> decltype(record.fields(), void()) {
  auto fields = record.fields();
  if (in.array() != std::tuple_size_v<decltype(fields)>) in.fail(FrameFault::arity);
  read_each(in, fields);
}

// --- writing -------------------------------------------------------------------------

void write(Writer& out, std::uint64_t value) { out.unsigned_number(value); }
void write(Writer& out, std::uint32_t value) { out.unsigned_number(value); }
void write(Writer& out, std::uint8_t value) { out.unsigned_number(value); }
void write(Writer& out, std::int64_t value) { out.signed_number(value); }
void write(Writer& out, double value) { out.number(value); }
void write(Writer& out, bool value) { out.boolean(value); }
void write(Writer& out, const NumberView& value) { out.binary(value.bytes()); }

template <std::size_t N>
void write(Writer& out, const FixedText<N>& value) {
  out.text(value.view());
}

template <std::size_t N>
void write(Writer& out, const std::array<std::uint8_t, N>& value) {
  out.binary(Bytes(value));
}

template <class Record>
auto write(Writer& out, const Record& record) -> decltype(record.fields(), void());

template <class T, std::size_t N>
void write(Writer& out, const FixedVec<T, N>& list) {
  out.array(list.size());
  for (const T& item : list) write(out, item);
}

template <class Tuple>
void write_each(Writer& out, const Tuple& fields) {
  std::apply([&out](const auto&... field) { (write(out, field), ...); }, fields);
}

template <class Record>
auto write(Writer& out, const Record& record) -> decltype(record.fields(), void()) {
  const auto fields = record.fields();
  out.array(std::tuple_size_v<std::remove_const_t<decltype(fields)>>);
  write_each(out, fields);
}

}  // namespace

std::string_view fault_name(FrameFault fault) {
  constexpr std::array<std::string_view, 10> names{"none",
                                                   "more than 64 KiB",
                                                   "cut short",
                                                   "wrong field type",
                                                   "wrong number of fields",
                                                   "another message type",
                                                   "another version",
                                                   "too long a name or list",
                                                   "not UTF-8, or a control character in a name",
                                                   "trailing bytes"};
  const auto number = static_cast<std::size_t>(fault);
  return number < names.size() ? names[number] : "unknown";
}

// The last fields, which older senders leave out.
template <class Message>
constexpr std::size_t optional_fields() {
  if constexpr (requires { Message::optional_fields; })
    return Message::optional_fields;
  else
    return std::size_t{0};
}

template <class Message>
FrameFault decode(Bytes frame, Message& message, std::size_t* at) {
  if (at != nullptr) *at = max_frame_bytes;
  if (frame.size() > max_frame_bytes) return FrameFault::oversized;
  Reader in(frame);
  auto fields = message.fields();
  const std::size_t count = in.array();
  // Type and version come before the arity: a newer version is named as such.
  if (count < 2) in.fail(FrameFault::arity);
  if (in.unsigned_number(UINT64_MAX) != Message::type_id) in.fail(FrameFault::message);
  if (in.unsigned_number(UINT64_MAX) != wire_version) in.fail(FrameFault::version);
  constexpr std::size_t most = std::tuple_size_v<decltype(fields)> + 2;
  if (count > most || count + optional_fields<Message>() < most) in.fail(FrameFault::arity);
  std::size_t left = count - 2;
  std::apply([&](auto&... field) { ((left-- > 0 ? read(in, field) : void()), ...); }, fields);
  if (in.ok() && !in.at_end()) in.fail(FrameFault::trailing);
  if (at != nullptr) *at = frame.size() - in.left();
  return in.fault();
}

template <class Message>
std::size_t encode(const Message& message, std::span<std::uint8_t> buffer) {
  Writer out(buffer);
  const auto fields = message.fields();
  out.array(std::tuple_size_v<std::remove_const_t<decltype(fields)>> + 2);
  out.unsigned_number(Message::type_id);
  out.unsigned_number(wire_version);
  write_each(out, fields);
  return out.size();
}

#define FAIRLEAD_MESSAGE(Type)                                                     \
  template FrameFault decode<Type>(Bytes frame, Type & message, std::size_t * at); \
  template std::size_t encode<Type>(const Type& message, std::span<std::uint8_t> buffer);

FAIRLEAD_MESSAGE(JointState)
FAIRLEAD_MESSAGE(HalStatus)
FAIRLEAD_MESSAGE(ActionChunk)
FAIRLEAD_MESSAGE(SafeChunk)
FAIRLEAD_MESSAGE(Lease)
FAIRLEAD_MESSAGE(Verdict)
FAIRLEAD_MESSAGE(GateStatus)
FAIRLEAD_MESSAGE(StopLevel)
FAIRLEAD_MESSAGE(Heartbeat)
FAIRLEAD_MESSAGE(Refusal)
FAIRLEAD_MESSAGE(Done)
FAIRLEAD_MESSAGE(StatusQuery)
FAIRLEAD_MESSAGE(Arm)
FAIRLEAD_MESSAGE(ArmReply)
FAIRLEAD_MESSAGE(Disarm)
FAIRLEAD_MESSAGE(Reset)
FAIRLEAD_MESSAGE(Claim)
FAIRLEAD_MESSAGE(ClaimReply)
FAIRLEAD_MESSAGE(Release)
FAIRLEAD_MESSAGE(LatchRecord)

#undef FAIRLEAD_MESSAGE

bool read_chunk_head(Bytes frame, ChunkHead& head) {
  Reader in(frame);
  (void)in.array();
  if (in.unsigned_number(UINT64_MAX) != ActionChunk::type_id) return false;
  (void)in.unsigned_number(UINT64_MAX);  // version
  (void)in.binary();                     // robot_hash
  head.session = in.unsigned_number(UINT64_MAX);
  head.epoch = in.unsigned_number(UINT64_MAX);
  head.claim_id = in.unsigned_number(UINT64_MAX);
  return in.ok();
}

}  // namespace fairlead
