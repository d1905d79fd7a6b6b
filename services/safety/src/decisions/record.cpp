#include "decisions/record.hpp"

#include <algorithm>
#include <cstring>
#include <vector>

#include "config/sha256.hpp"

namespace fairlead {
namespace {

// A frame beyond what the core reads is refused by its size alone: one byte more says as much.
constexpr std::size_t kKeptPayload = max_frame_bytes + 1;

Bytes bytes_of(std::string_view text) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

std::string_view text_of(Bytes bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

/// Writes into a buffer that is large enough.
class Writer {
 public:
  explicit Writer(std::span<std::uint8_t> buffer) : buffer_(buffer) {}
  template <class Number>
  void number(Number value) {
    std::memcpy(buffer_.data() + used_, &value, sizeof value);  // little-endian hosts only
    used_ += sizeof value;
  }
  void raw(Bytes bytes) {
    if (!bytes.empty()) std::memcpy(buffer_.data() + used_, bytes.data(), bytes.size());
    used_ += bytes.size();
  }
  template <class Length>
  void sized(Bytes bytes) {
    number(static_cast<Length>(bytes.size()));
    raw(bytes);
  }
  std::size_t used() const { return used_; }

 private:
  std::span<std::uint8_t> buffer_;
  std::size_t used_ = 0;
};

/// Reads a body; after the first thing that is not there everything is empty and `ok` false.
class Reader {
 public:
  explicit Reader(Bytes bytes) : left_(bytes) {}
  template <class Number>
  Number number() {
    Number value{};
    const Bytes bytes = raw(sizeof value);
    if (ok_) std::memcpy(&value, bytes.data(), sizeof value);
    return value;
  }
  Bytes raw(std::size_t size) {
    if (!ok_ || size > left_.size()) {
      ok_ = false;
      return {};
    }
    const Bytes bytes = left_.first(size);
    left_ = left_.subspan(size);
    return bytes;
  }
  template <class Length>
  Bytes sized() {
    return raw(number<Length>());
  }
  Bytes rest() { return raw(left_.size()); }
  bool ok_and_done() const { return ok_ && left_.empty(); }

 private:
  Bytes left_;
  bool ok_ = true;
};

void take_outputs(const Outputs& outputs, Record& record) {
  for (const Output& output : outputs.items())
    (void)record.outputs.push_back(
        RecordedOutput{output.kind, output.source.view(), outputs.payload(output)});
  record.output_count = static_cast<std::uint8_t>(record.outputs.size());
}

void write_results(const Record& record, Writer& out) {
  out.number(static_cast<std::uint8_t>(record.ids.size()));
  for (const std::uint64_t id : record.ids) out.number(id);
  out.number(record.output_count);
  if (record.output_count == 0) return;
  out.raw(record.digest);
  out.number(static_cast<std::uint8_t>(record.outputs.size()));
  for (const RecordedOutput& output : record.outputs) {
    out.number(static_cast<std::uint8_t>(output.kind));
    out.sized<std::uint8_t>(bytes_of(output.source));
    out.sized<std::uint32_t>(output.payload);
  }
}

bool read_results(Reader& in, Record& record) {
  const auto ids = in.number<std::uint8_t>();
  for (std::size_t i = 0; i < ids; ++i)
    if (!record.ids.push_back(in.number<std::uint64_t>())) return false;
  record.output_count = in.number<std::uint8_t>();
  if (record.output_count == 0) return true;
  const Bytes digest = in.raw(record.digest.size());
  std::copy(digest.begin(), digest.end(), record.digest.begin());
  const auto kept = in.number<std::uint8_t>();
  for (std::size_t i = 0; i < kept; ++i) {
    RecordedOutput output;
    output.kind = static_cast<OutputKind>(in.number<std::uint8_t>());
    output.source = text_of(in.sized<std::uint8_t>());
    output.payload = in.sized<std::uint32_t>();
    if (!record.outputs.push_back(output)) return false;
  }
  return true;
}

}  // namespace

Record boot_record(std::uint64_t now_ns, const BootInfo& info, std::span<const std::uint64_t> ids,
                   const Outputs& outputs) {
  Record record;
  record.type = RecordType::boot;
  record.now_ns = now_ns;
  record.boot = info;
  for (const std::uint64_t id : ids) (void)record.ids.push_back(id);
  take_outputs(outputs, record);
  return record;
}

Record step_record(std::uint64_t now_ns, const Event& event, std::span<const std::uint64_t> ids,
                   const Outputs& outputs) {
  Record record;
  const bool quiet = event.kind == EventKind::timer && ids.empty() && outputs.items().empty();
  record.type = quiet ? RecordType::timer : RecordType::step;
  record.now_ns = now_ns;
  record.event = event;
  record.event.payload =
      event.payload.first(std::min<std::size_t>(event.payload.size(), kKeptPayload));
  record.event.source = event.source.substr(0, Name::capacity + 1);
  for (const std::uint64_t id : ids) (void)record.ids.push_back(id);
  take_outputs(outputs, record);
  return record;
}

std::size_t room_for(const Record& record) {
  std::size_t room = 128 + 8 * record.ids.size() + record.event.source.size() +
                     record.event.payload.size() + record.boot.latch.size() + record.text.size();
  for (const RecordedOutput& output : record.outputs)
    room += 8 + output.source.size() + output.payload.size();
  return room;
}

std::size_t encode_record(const Record& record, std::span<std::uint8_t> buffer) {
  Writer out(buffer);
  switch (record.type) {
    case RecordType::header:
    case RecordType::end:
      out.raw(bytes_of(record.text));
      break;
    case RecordType::gap:
      out.number(record.lost);
      break;
    case RecordType::timer:
      out.number(record.now_ns);
      out.number(record.event.previous_step_ns);
      break;
    case RecordType::boot:
      out.number(record.now_ns);
      out.number(static_cast<std::uint8_t>(record.boot.first_start));
      out.number(static_cast<std::uint8_t>(record.boot.clean_mark));
      out.number(static_cast<std::uint8_t>(record.boot.new_state));
      out.sized<std::uint32_t>(record.boot.latch);
      write_results(record, out);
      break;
    case RecordType::step:
      out.number(record.now_ns);
      out.number(record.event.received_ns);
      out.number(record.event.previous_step_ns);
      out.number(static_cast<std::uint8_t>(record.event.kind));
      out.sized<std::uint8_t>(bytes_of(record.event.source));
      out.sized<std::uint32_t>(record.event.payload);
      write_results(record, out);
      break;
  }
  return out.used();
}

bool decode_record(RecordType type, Bytes body, Record& record) {
  record = Record();
  record.type = type;
  Reader in(body);
  switch (type) {
    case RecordType::header:
    case RecordType::end:
      record.text = text_of(in.rest());
      break;
    case RecordType::gap:
      record.lost = in.number<std::uint64_t>();
      break;
    case RecordType::timer:
      record.now_ns = in.number<std::uint64_t>();
      record.event.previous_step_ns = in.number<std::uint32_t>();
      break;
    case RecordType::boot:
      record.now_ns = in.number<std::uint64_t>();
      record.boot.first_start = in.number<std::uint8_t>() != 0;
      record.boot.clean_mark = in.number<std::uint8_t>() != 0;
      record.boot.new_state = in.number<std::uint8_t>() != 0;
      record.boot.latch = in.sized<std::uint32_t>();
      if (!read_results(in, record)) return false;
      break;
    case RecordType::step:
      record.now_ns = in.number<std::uint64_t>();
      record.event.received_ns = in.number<std::uint64_t>();
      record.event.previous_step_ns = in.number<std::uint32_t>();
      record.event.kind = static_cast<EventKind>(in.number<std::uint8_t>());
      record.event.source = text_of(in.sized<std::uint8_t>());
      record.event.payload = in.sized<std::uint32_t>();
      if (!read_results(in, record)) return false;
      break;
    default:
      return false;
  }
  return in.ok_and_done();
}

Digest digest_of(const RecordedOutputs& outputs) {
  std::vector<std::uint8_t> all;
  for (const RecordedOutput& output : outputs) {
    const std::array<std::uint64_t, 3> sizes = {static_cast<std::uint64_t>(output.kind),
                                                output.source.size(), output.payload.size()};
    const auto* head = reinterpret_cast<const std::uint8_t*>(sizes.data());
    all.insert(all.end(), head, head + sizeof sizes);
    all.insert(all.end(), output.source.begin(), output.source.end());
    all.insert(all.end(), output.payload.begin(), output.payload.end());
  }
  const Hash hash = sha256(all);
  Digest digest{};
  std::copy_n(hash.begin(), digest.size(), digest.begin());
  return digest;
}

}  // namespace fairlead
