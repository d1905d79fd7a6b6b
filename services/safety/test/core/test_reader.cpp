// The cursor over a msgpack frame, by itself: what is read, what fails, and that a fault sticks.

#include <doctest/doctest.h>

#include <string>
#include <vector>

#include "core/wire/msgpack.hpp"

using namespace fairlead;

namespace {

using Frame = std::vector<std::uint8_t>;

struct SignedCase {
  Frame frame;
  std::int64_t value;
};

// A text of exactly these bytes (at most 31).
Frame text_of(const std::string& bytes) {
  Frame frame(bytes.begin(), bytes.end());
  frame.insert(frame.begin(), static_cast<std::uint8_t>(0xA0U + bytes.size()));
  return frame;
}

bool is_text(const std::string& bytes) {
  const Frame frame = text_of(bytes);
  Reader reader{frame};
  return reader.text() == bytes && reader.ok();
}

}  // namespace

TEST_CASE("signed numbers in each of their forms") {
  const std::vector<SignedCase> cases{{{0x00}, 0},
                                      {{0x7F}, 127},
                                      {{0xE0}, -32},
                                      {{0xFF}, -1},
                                      {{0xCC, 0x00}, 0},
                                      {{0xCC, 0x80}, 128},
                                      {{0xCD, 0x01, 0x00}, 256},
                                      {{0xCE, 0x80, 0, 0, 0}, 2'147'483'648},
                                      {{0xCF, 0x7F, 255, 255, 255, 255, 255, 255, 255}, INT64_MAX},
                                      {{0xD0, 0x80}, -128},
                                      {{0xD0, 0x7F}, 127},
                                      {{0xD1, 0x80, 0x00}, -32768},
                                      {{0xD2, 0x80, 0, 0, 0}, INT32_MIN},
                                      {{0xD3, 0x80, 0, 0, 0, 0, 0, 0, 0}, INT64_MIN},
                                      {{0xD3, 255, 255, 255, 255, 255, 255, 255, 0xFE}, -2}};
  for (const SignedCase& one : cases) {
    Reader reader{one.frame};
    CHECK(reader.signed_number() == one.value);
    CHECK(reader.ok());
    CHECK(reader.at_end());
  }
}

TEST_CASE("what is no signed number reads as 0, and the fault is told") {
  // Behind each stand digits that a careless reader would take for its number.
  for (const std::uint8_t lead :
       Frame{0x80, 0x90, 0xA1, 0xBF, 0xC0, 0xC3, 0xCA, 0xCB, 0xD4, 0xD9, 0xDF}) {
    const Frame frame{lead, 1, 2, 3, 4, 5, 6, 7, 8};
    Reader reader{frame};
    CHECK(reader.signed_number() == 0);
    CHECK(reader.fault() == FrameFault::wrong_type);
  }
  const Frame beyond{0xCF, 0x80, 0, 0, 0, 0, 0, 0, 0};
  Reader reader{beyond};
  CHECK(reader.signed_number() == 0);
  CHECK(reader.fault() == FrameFault::wrong_type);
}

TEST_CASE("unsigned numbers up to the highest that fits; anything else is 0 and a fault") {
  const Frame most{0xCD, 0xFF, 0xFF};
  Reader fits{most};
  CHECK(fits.unsigned_number(0xFFFF) == 0xFFFF);
  CHECK(fits.ok());
  Reader over{most};
  CHECK(over.unsigned_number(0xFFFE) == 0);
  CHECK(over.fault() == FrameFault::wrong_type);
  for (const std::uint8_t lead : Frame{0x80, 0xCB, 0xD0, 0xE0, 0xFF}) {
    const Frame frame{lead, 1, 1, 1, 1, 1, 1, 1, 1};
    Reader reader{frame};
    CHECK(reader.unsigned_number(UINT64_MAX) == 0);
    CHECK(reader.fault() == FrameFault::wrong_type);
  }
  const Frame small{0x7F};
  Reader plain{small};
  CHECK(plain.unsigned_number(UINT64_MAX) == 127);
}

TEST_CASE("a number that is cut short is 0 and a fault") {
  for (const std::uint8_t lead : Frame{0xCC, 0xCD, 0xCE, 0xCF, 0xD0, 0xD1, 0xD2, 0xD3}) {
    const Frame frame{lead};
    Reader reader{frame};
    CHECK(reader.signed_number() == 0);
    CHECK(reader.fault() == FrameFault::cut_short);
  }
  const Frame none;
  Reader reader{none};
  CHECK(reader.unsigned_number(9) == 0);
  CHECK(reader.fault() == FrameFault::cut_short);
}

TEST_CASE("floats, doubles and whole numbers are numbers") {
  const Frame half{0xCA, 0x3F, 0x00, 0, 0};
  Reader floats{half};
  CHECK(floats.number() == 0.5);
  const Frame minus_two{0xCB, 0xC0, 0, 0, 0, 0, 0, 0, 0};
  Reader doubles{minus_two};
  CHECK(doubles.number() == -2.0);
  const Frame minus_one{0xFF};
  Reader whole{minus_one};
  CHECK(whole.number() == -1.0);
  const Frame nothing;
  Reader reader{nothing};
  CHECK(reader.number() == 0.0);
  CHECK_FALSE(reader.ok());
}

TEST_CASE("texts are UTF-8: the edges of every range") {
  for (const char* good :
       {"a", "\x7F", "\xC2\x80", "\xDF\xBF", "\xE0\xA0\x80", "\xED\x9F\xBF", "\xEE\x80\x80",
        "\xEF\xBF\xBF", "\xF0\x90\x80\x80", "\xF4\x8F\xBF\xBF", "x\xC3\xA9y", ""})
    CHECK(is_text(good));
  for (const char* bad : {"\x80",
                          "\xBF",
                          "\xC1\xBF",
                          "\xC2",
                          "\xC2\x7F",
                          "\xC2\xC0",
                          "\xE0\x9F\xBF",
                          "\xE0\x80\x80",
                          "\xED\xA0\x80",
                          "\xED\xBF\xBF",
                          "\xE1\x80",
                          "\xF0\x8F\xBF\xBF",
                          "\xF0\x80\x80\x80",
                          "\xF4\x90\x80\x80",
                          "\xF5\x80\x80\x80",
                          "\xF1\x80\x80",
                          "\xF1\x80\x80\x7F",
                          "\xFF",
                          "\xE1\x80\xC0",
                          "\xF1\x80\x80\xC0",
                          "\xE0\xA0\x7F"}) {
    const Frame frame = text_of(bad);
    Reader reader{frame};
    CHECK(reader.text().empty());
    CHECK(reader.fault() == FrameFault::text);
  }
}

TEST_CASE("an overlong character or a surrogate is no text, whatever follows it") {
  for (const char* bad :
       {"\xE0\x9F\xBFz", "\xED\xA0\x80z", "\xF0\x8F\xBF\xBFz", "\xF4\x90\x80\x80z"}) {
    const Frame frame = text_of(bad);
    Reader reader{frame};
    (void)reader.text();
    CHECK(reader.fault() == FrameFault::text);
  }
}

TEST_CASE("texts and bytes with lengths of one, two and four bytes") {
  const std::string words(300, 'w');
  for (const std::uint8_t lead : Frame{0xDA, 0xC5}) {
    Frame frame{lead, 0x01, 0x2C};
    frame.insert(frame.end(), words.begin(), words.end());
    Reader reader{frame};
    if (lead == 0xDA)
      CHECK(reader.text() == words);
    else
      CHECK(reader.binary().size() == 300);
    CHECK(reader.ok());
    CHECK(reader.at_end());
  }
  const Frame one{0xD9, 0x01, 'q'};
  Reader texts{one};
  CHECK(texts.text() == "q");
  const Frame four{0xDB, 0, 0, 0, 1, 'q'};
  Reader longs{four};
  CHECK(longs.text() == "q");
  const Frame bytes{0xC6, 0, 0, 0, 1, 7};
  Reader binaries{bytes};
  REQUIRE(binaries.binary().size() == 1);
  CHECK(binaries.at_end());
}

TEST_CASE("no text and no bytes: empty, and the first fault sticks") {
  const Frame frame{0xC4, 'a', 'b'};
  Reader reader{frame};
  CHECK(reader.text().empty());
  CHECK(reader.fault() == FrameFault::wrong_type);
  CHECK(reader.at_end());  // nothing is read after a fault
  CHECK(reader.unsigned_number(9) == 0);
  CHECK(reader.fault() == FrameFault::wrong_type);

  const Frame text{0xA1, 'a'};
  Reader bytes{text};
  CHECK(bytes.binary().empty());
  CHECK(bytes.fault() == FrameFault::wrong_type);
  CHECK(bytes.at_end());
}

TEST_CASE("arrays: the short, the 16-bit and the 32-bit form") {
  const Frame shortest{0x90};
  Reader none{shortest};
  CHECK(none.array() == 0);
  CHECK(none.ok());
  const Frame longest{0x9F};
  Reader fifteen{longest};
  CHECK(fifteen.array() == 15);
  const Frame sixteen{0xDC, 0x01, 0x02};
  Reader wide{sixteen};
  CHECK(wide.array() == 258);
  CHECK(wide.at_end());
  const Frame thirty_two{0xDD, 0, 1, 0, 2};
  Reader wider{thirty_two};
  CHECK(wider.array() == 65538);
  for (const std::uint8_t lead : Frame{0x8F, 0xA0, 0xA5, 0xDB, 0xDE, 0x01}) {
    const Frame frame{lead, 0, 0, 0, 3};
    Reader reader{frame};
    CHECK(reader.array() == 0);
    CHECK(reader.fault() == FrameFault::wrong_type);
  }
}

TEST_CASE("booleans are true or false, nothing else") {
  const Frame yes{0xC3};
  Reader right{yes};
  CHECK(right.boolean());
  const Frame no{0xC2};
  Reader left{no};
  CHECK_FALSE(left.boolean());
  CHECK(left.ok());
  const Frame one{0x01};
  Reader number{one};
  CHECK_FALSE(number.boolean());
  CHECK(number.fault() == FrameFault::wrong_type);
}
