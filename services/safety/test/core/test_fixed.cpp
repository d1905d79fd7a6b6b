// Lists of fixed room, and single rows: what each says about itself.
#include <doctest/doctest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>

#include "chunk_builder.hpp"
#include "core/modes/commanded_motion.hpp"
#include "core/release/part_history.hpp"

using namespace fairlead;
using namespace fairlead::test;

TEST_CASE("lists are equal if they are as long and equal item by item") {
  const auto list = [](std::initializer_list<std::uint64_t> items) {
    FixedVec<std::uint64_t, 4> made;
    for (const std::uint64_t item : items) (void)made.push_back(item);
    return made;
  };
  CHECK(list({}) == list({}));
  CHECK(list({1, 2}) == list({1, 2}));
  CHECK_FALSE(list({1, 2}) == list({1}));
  CHECK_FALSE(list({1, 2}) == list({1, 3}));
  CHECK_FALSE(list({1, 2}) == list({3, 2}));
  FixedVec<std::uint64_t, 4> shrunk = list({1, 2, 3});
  (void)shrunk.resize(2);
  CHECK(shrunk == list({1, 2}));
}

namespace {

// The signal that ends a process which reads so.
int ends_by(const auto& read) {
  const pid_t child = fork();
  REQUIRE(child >= 0);
  if (child == 0) {
    (void)std::signal(SIGABRT, SIG_DFL);  // not doctest's report
    _exit(static_cast<int>(read()));
  }
  int status = 0;
  REQUIRE(waitpid(child, &status, 0) == child);
  return WIFSIGNALED(status) ? WTERMSIG(status) : 0;
}

}  // namespace

TEST_CASE("reading beyond a list, or a block of a frame, ends the process") {
  FixedVec<std::uint64_t, 4> list;
  (void)list.push_back(1);
  CHECK(ends_by([&] { return list[list.size() - 1]; }) == 0);
  CHECK(ends_by([&] { return list[list.size()]; }) == SIGABRT);
  const std::array<std::uint8_t, 17> bytes{};
  const NumberView numbers{Bytes(bytes)};
  CHECK(ends_by([&] { return numbers[1]; }) == 0);
  CHECK(ends_by([&] { return numbers[2]; }) == SIGABRT);
}

TEST_CASE("a row of a joint mode commands the joints it names, one of another mode none") {
  const ChunkBuilder joints = ChunkBuilder().joint(arm, Mode::joint_position, arm_2, {0.5});
  const Setpoint row{&joints.chunk.parts[0]};
  CHECK(row.commands(arm_2));
  CHECK_FALSE(row.commands(arm_1));
  ChunkBuilder tool = ChunkBuilder().along(arm, Mode::cartesian_delta, 0, {0.01});
  (void)tool.chunk.parts[0].active.push_back(arm_2);
  CHECK_FALSE(Setpoint{&tool.chunk.parts[0]}.commands(arm_2));
}

TEST_CASE("a part of which rows of two commands may still act does something nobody knows") {
  const ChunkBuilder delta = ChunkBuilder().along(arm, Mode::cartesian_delta, 0, {0.01});
  const ChunkBuilder twist = ChunkBuilder().along(arm, Mode::cartesian_twist, 0, {0.01});
  PartMemory memory;
  memory.add(delta.chunk.parts[0]);
  CHECK(memory.kind == PartMemory::Kind::known);
  memory.add(delta.chunk.parts[0]);
  CHECK(memory.kind == PartMemory::Kind::known);
  CHECK_FALSE(memory.differs(delta.chunk.parts[0]));
  memory.add(twist.chunk.parts[0]);
  CHECK(memory.kind == PartMemory::Kind::unknown);
  CHECK(memory.differs(delta.chunk.parts[0]));
  CHECK(memory.differs(twist.chunk.parts[0]));
}
