// How the core puts numbers into words.

#include <doctest/doctest.h>

#include <limits>

#include "core/wire/phrase.hpp"

using namespace fairlead;

TEST_CASE("numbers are told as short as they can be, and what is none has no sign") {
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  CHECK(phrase("0.1 is ", 0.1).view() == "0.1 is 0.1");
  CHECK(phrase(-3, " and ", 7U).view() == "-3 and 7");
  CHECK(phrase("value ", -nan, ", ", nan).view() == "value nan, nan");
  CHECK(phrase(-std::numeric_limits<double>::infinity()).view() == "-inf");
}

TEST_CASE("an id is told with all its digits") {
  CHECK(phrase("stop ", Hex{0xf}).view() == "stop 000000000000000f");
}
