// Which stops are held, and what counts within a window of ticks, by themselves.

#include <doctest/doctest.h>

#include "core/gate/state_machine.hpp"

using namespace fairlead;

namespace {

constexpr std::uint64_t s = 1'000'000'000;

}  // namespace

TEST_CASE("a window counts the events of its own ticks, the present one among them") {
  TickWindow<4> window;
  CHECK(window.count(10, 5) == 0);
  window.add(10);
  CHECK(window.count(10, 1) == 1);
  CHECK(window.count(14, 5) == 1);
  CHECK(window.count(15, 5) == 0);
  for (std::uint64_t tick = 11; tick < 14; ++tick) window.add(tick);
  CHECK(window.count(14, 5) == 4);
  window.add(14);  // the first is forgotten: there is room for four
  CHECK(window.count(14, 5) == 4);
  CHECK(window.count(14, 100) == 4);
}

TEST_CASE("a window rebased counts its events by their age when the session ended") {
  TickWindow<4> window;
  window.add(900);
  window.add(901);
  window.rebase(902);
  CHECK(window.count(1, 4) == 2);
  CHECK(window.count(2, 4) == 1);
  CHECK(window.count(3, 4) == 0);
  window.add(3);
  CHECK(window.count(3, 5) == 2);
  window.rebase(3);  // nor does another session make them any younger
  CHECK(window.count(1, 5) == 1);
  CHECK(window.count(1, 6) == 2);
  for (std::uint64_t i = 0; i < 4; ++i) window.add(6);
  CHECK(window.count(6, 1) == 4);
}

TEST_CASE("a stop is held once, and cleared by its own id only") {
  StopBook book;
  CHECK(book.hold(7));
  CHECK_FALSE(book.hold(7));
  CHECK(book.held().size() == 1);
  CHECK(book.hold(8));
  CHECK_FALSE(book.reset(9, s));
  CHECK(book.reset(7, s));
  CHECK_FALSE(book.reset(7, s));
  REQUIRE(book.held().size() == 1);
  CHECK(book.held()[0] == 8);
}

TEST_CASE("there is room for sixteen stops; one more is not held, and says so") {
  StopBook book;
  for (std::uint64_t id = 1; id <= 16; ++id) CHECK(book.hold(id));
  CHECK_FALSE(book.hold(17));
  CHECK(book.reset(1, s));
  CHECK(book.hold(17));
}

TEST_CASE("a late copy is one that comes within two seconds of the reset or of the copy before") {
  StopBook book;
  book.hold(7);
  CHECK_FALSE(book.is_late_copy(7, s));  // it is held, not reset
  book.reset(7, s);
  CHECK(book.is_late_copy(7, 3 * s));
  CHECK(book.is_late_copy(7, 5 * s));
  CHECK_FALSE(book.is_late_copy(8, 5 * s));
  CHECK_FALSE(book.is_late_copy(7, 7 * s + 1));
  CHECK_FALSE(book.is_late_copy(7, 7 * s + 1));  // and it stays forgotten
}

TEST_CASE("a stop whose reset is forgotten is a stop like any other; the others' are not") {
  StopBook book;
  for (const std::uint64_t id : {std::uint64_t{7}, std::uint64_t{8}}) {
    book.hold(id);
    book.reset(id, s);
  }
  book.forget(7);
  CHECK_FALSE(book.is_late_copy(7, s));
  CHECK(book.is_late_copy(8, s));
}

TEST_CASE("the gate's own stops are counted within the window, across sessions of the HAL") {
  StopBook book;
  CHECK(book.note_raised(1000, 100) == 1);
  CHECK(book.note_raised(1099, 100) == 2);
  CHECK(book.note_raised(1100, 100) == 2);
  book.begin_session(1120);
  CHECK(book.note_raised(50, 100) == 3);  // 71, 70 and no ticks ago
  CHECK(book.note_raised(80, 100) == 2);
}
