// The list of what a step wants done holds what fits, and says when something did not.

#include <doctest/doctest.h>

#include <memory>
#include <string>

#include "fairlead_safety/outputs.hpp"
#include "fairlead_safety/query_messages.hpp"

using namespace fairlead;

TEST_CASE("outputs keep their order and their bytes") {
  const auto outputs = std::make_unique<Outputs>();
  outputs->add(OutputKind::clear_clean_mark);
  outputs->add_log("a line");
  outputs->add(OutputKind::reply, "runner", Done{"done"});
  REQUIRE(outputs->items().size() == 3);
  CHECK(outputs->items()[0].kind == OutputKind::clear_clean_mark);
  CHECK(outputs->payload(outputs->items()[0]).empty());
  CHECK(outputs->payload(outputs->items()[1]).size() == 6);
  CHECK(outputs->items()[2].source == "runner");
  Done done;
  CHECK(decode(outputs->payload(outputs->items()[2]), done) == FrameFault::none);
  CHECK(done.text == "done");
  outputs->clear();
  CHECK(outputs->items().empty());
  CHECK_FALSE(outputs->overflowed());
}

TEST_CASE("too many outputs are reported, not overrun") {
  const auto outputs = std::make_unique<Outputs>();
  for (int i = 0; i < 96; ++i) outputs->add(OutputKind::write_clean_mark);
  CHECK_FALSE(outputs->overflowed());
  outputs->add(OutputKind::write_clean_mark);
  CHECK(outputs->overflowed());
  outputs->clear();  // said of one step, not of those after it
  CHECK_FALSE(outputs->overflowed());
}

TEST_CASE("too many bytes are reported, not overrun") {
  const auto outputs = std::make_unique<Outputs>();
  const std::string line(max_frame_bytes, 'x');
  for (int i = 0; i < 20; ++i) outputs->add_log(line);
  CHECK_FALSE(outputs->overflowed());
  outputs->add(OutputKind::reply, "runner", Done{"done"});
  CHECK(outputs->overflowed());
}

TEST_CASE("a line of the log may be empty, and is cut where no room is left: that is no fault") {
  const auto outputs = std::make_unique<Outputs>();
  outputs->add_log("");
  REQUIRE(outputs->items().size() == 1);
  CHECK(outputs->payload(outputs->items()[0]).empty());
  CHECK_FALSE(outputs->overflowed());
}
