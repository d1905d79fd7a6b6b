// The decision log's file: what was written is read back, and what was not is never believed.
#include <doctest/doctest.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "decisions/log_file.hpp"
#include "decisions/log_reader.hpp"
#include "decisions/record_ring.hpp"
#include "process/refusal.hpp"

using namespace fairlead;
namespace fs = std::filesystem;

namespace {

class Folder {
 public:
  Folder() {
    std::string name = (fs::temp_directory_path() / "fairlead-decisions-XXXXXX").string();
    REQUIRE(::mkdtemp(name.data()) != nullptr);
    path = name;
  }
  ~Folder() { fs::remove_all(path); }
  fs::path path;
};

using Buffer = std::vector<std::uint8_t>;

Bytes bytes_of(std::string_view text) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

const Buffer kPayload = {1, 2, 3, 4, 5};

Record a_step(std::uint64_t now_ns) {
  Record record;
  record.type = RecordType::step;
  record.now_ns = now_ns;
  record.event = Event{EventKind::candidate, "runner", kPayload, now_ns - 7, 0xFEDCBA98};
  (void)record.ids.push_back(0xFEDCBA9876543210);
  record.output_count = 3;
  record.digest[0] = 42;
  (void)record.outputs.push_back(RecordedOutput{OutputKind::verdict, "runner", kPayload});
  return record;
}

Buffer body_of(const Record& record) {
  Buffer body(room_for(record));
  body.resize(encode_record(record, body));
  return body;
}

std::string file_text(const fs::path& path) {
  std::ifstream stream(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
}

fs::path write_text(const Folder& folder, const std::string& text) {
  const fs::path path = folder.path / "changed.decisions";
  std::ofstream(path, std::ios::binary | std::ios::trunc) << text;
  return path;
}

/// A log with a header, `steps` steps and an end.
std::string written_log(const Folder& folder, int steps) {
  std::string fault;
  LogFile file(folder.path, 10, UINT64_MAX, fault);
  REQUIRE(fault == "");
  REQUIRE(file.append(RecordType::header, bytes_of("{}")) == "");
  for (int i = 0; i < steps; ++i)
    REQUIRE(file.append(RecordType::step, body_of(a_step(1000 + static_cast<std::uint64_t>(i)))) ==
            "");
  REQUIRE(file.append(RecordType::end, bytes_of("done")) == "");
  return file_text(file.path());
}

/// Steps that could be read; throws as LogReader does.
int steps_in(const fs::path& path, LogEnd& end) {
  LogReader reader(path);
  Record record;
  int steps = 0;
  while (reader.next(record)) steps += record.type == RecordType::step ? 1 : 0;
  end = reader.end();
  return steps;
}

}  // namespace

TEST_CASE("a step comes back as it was recorded") {
  const Buffer body = body_of(a_step(123456789));
  Record read;
  REQUIRE(decode_record(RecordType::step, body, read));
  CHECK(read.now_ns == 123456789);
  CHECK(read.event.received_ns == 123456782);
  CHECK(read.event.previous_step_ns == 0xFEDCBA98);
  CHECK(read.event.kind == EventKind::candidate);
  CHECK(read.event.source == "runner");
  CHECK(Buffer(read.event.payload.begin(), read.event.payload.end()) == kPayload);
  REQUIRE(read.ids.size() == 1);
  CHECK(read.ids[0] == 0xFEDCBA9876543210);
  CHECK(read.output_count == 3);
  CHECK(read.digest[0] == 42);
  REQUIRE(read.outputs.size() == 1);
  CHECK(read.outputs[0].kind == OutputKind::verdict);
  CHECK(read.outputs[0].payload.size() == 5);
}

TEST_CASE("a body that is too short or too long is no record") {
  const Buffer body = body_of(a_step(1));
  Record read;
  for (std::size_t size = 0; size < body.size(); ++size)
    CHECK_FALSE(decode_record(RecordType::step, Bytes(body).first(size), read));
  Buffer longer = body;
  longer.push_back(0);
  CHECK_FALSE(decode_record(RecordType::step, longer, read));
  CHECK_FALSE(decode_record(static_cast<RecordType>(77), body, read));
}

TEST_CASE("a frame that the core refuses by its size is kept up to one byte beyond that size") {
  const Buffer big(200'000);
  const auto outputs = std::make_unique<Outputs>();
  Event event;
  event.kind = EventKind::candidate;
  event.payload = big;
  CHECK(step_record(1, event, {}, *outputs).event.payload.size() == max_frame_bytes + 1);
}

TEST_CASE("a timer step without outputs or ids is recorded by its times alone") {
  const auto outputs = std::make_unique<Outputs>();
  Event event;
  event.previous_step_ns = 0x89ABCDEF;
  const Buffer body = body_of(step_record(7, event, {}, *outputs));
  CHECK(body.size() == 12);
  Record read;
  REQUIRE(decode_record(RecordType::timer, body, read));
  CHECK(read.now_ns == 7);
  CHECK(read.event.previous_step_ns == 0x89ABCDEF);
  CHECK(step_record(1, Event{}, {}, *outputs).type == RecordType::timer);
  const std::uint64_t id = 5;
  CHECK(step_record(1, Event{}, {&id, 1}, *outputs).type == RecordType::step);
  outputs->add_log("something");
  CHECK(step_record(1, Event{}, {}, *outputs).type == RecordType::step);
}

TEST_CASE("a whole log is read to its end") {
  const Folder folder;
  written_log(folder, 5);
  LogReader reader(folder.path / "000001.decisions");
  CHECK(reader.header() == "{}");
  Record record;
  int steps = 0;
  while (reader.next(record)) steps += record.type == RecordType::step ? 1 : 0;
  CHECK(steps == 5);
  CHECK(reader.end() == LogEnd::complete);
  CHECK(reader.end_text() == "complete: done");
}

TEST_CASE("a log cut at any byte is read up to the last whole record") {
  const Folder folder;
  const std::string text = written_log(folder, 3);
  const std::size_t first = text.size() - 9 - 4 - 3 * (body_of(a_step(1)).size() + 9);
  for (std::size_t size = first; size < text.size(); ++size) {
    LogEnd end{};
    const int steps = steps_in(write_text(folder, text.substr(0, size)), end);
    CHECK(steps == static_cast<int>((size - first) / (body_of(a_step(1)).size() + 9)));
    CHECK((end == LogEnd::open || end == LogEnd::torn));
  }
}

TEST_CASE("any changed byte is found") {
  const Folder folder;
  const std::string text = written_log(folder, 2);
  for (std::size_t i = 0; i < text.size(); ++i) {
    std::string changed = text;
    changed[i] = static_cast<char>(changed[i] ^ 1);
    LogEnd end{};
    try {
      (void)steps_in(write_text(folder, changed), end);
    } catch (const ConfigRefused&) {
      continue;  // the first line or the header
    }
    CHECK(end == LogEnd::damaged);
  }
}

TEST_CASE("a record taken out is found, and so are two that changed places") {
  const Folder folder;
  const std::string text = written_log(folder, 3);
  const std::size_t frame = body_of(a_step(1)).size() + 9;
  const std::size_t first = text.size() - 9 - 4 - 3 * frame;
  const auto piece = [&](std::size_t i) { return text.substr(first + i * frame, frame); };
  const std::string head = text.substr(0, first);
  const std::string tail = text.substr(first + 3 * frame);
  LogEnd end{};
  CHECK(steps_in(write_text(folder, head + piece(0) + piece(2) + tail), end) == 1);
  CHECK(end == LogEnd::damaged);
  CHECK(steps_in(write_text(folder, head + piece(1) + piece(0) + piece(2) + tail), end) == 0);
  CHECK(end == LogEnd::damaged);
  CHECK(steps_in(write_text(folder, head + piece(0) + piece(1) + piece(2) + tail), end) == 3);
  CHECK(end == LogEnd::complete);
}

TEST_CASE("a log of another layout, older or newer, is refused by its number") {
  const Folder folder;
  std::string text = written_log(folder, 1);
  for (const char layout : {'1', '3'}) {
    text[text.find('\n') - 1] = layout;
    LogEnd end{};
    std::string said;
    try {
      steps_in(write_text(folder, text), end);
    } catch (const ConfigRefused& refusal) {
      said = refusal.what();
    }
    CHECK(said.find(std::string("it has layout ") + layout + ", this gate reads layout 2 only") !=
          std::string::npos);
  }
}

TEST_CASE("a gap says how many records are missing") {
  Record gap;
  gap.type = RecordType::gap;
  gap.lost = 17;
  Record read;
  REQUIRE(decode_record(RecordType::gap, body_of(gap), read));
  CHECK(read.lost == 17);
}

TEST_CASE("the ring gives records back in order, however often it wraps") {
  RecordRing ring(100);
  std::uint8_t written = 0;
  std::uint8_t read = 0;
  for (int round = 0; round < 200; ++round) {
    const std::size_t size = 1 + static_cast<std::size_t>(round) % 29;
    while (true) {
      const std::span<std::uint8_t> room = ring.reserve(size);
      if (room.empty()) break;
      room[0] = written++;
      ring.commit(size);
    }
    CHECK(written != read);
    while (read != written) {
      const Bytes record = ring.front();
      REQUIRE_FALSE(record.empty());
      CHECK(record[0] == read++);
      CHECK(record.size() == size);
      ring.pop();
    }
    CHECK(ring.front().empty());
  }
}

TEST_CASE("a full ring has no room until a record is taken out") {
  RecordRing ring(64);
  CHECK(ring.reserve(61).empty());
  REQUIRE_FALSE(ring.reserve(40).empty());
  ring.commit(40);
  CHECK(ring.reserve(30).empty());
  REQUIRE_FALSE(ring.front().empty());
  ring.pop();
  CHECK_FALSE(ring.reserve(30).empty());
}
