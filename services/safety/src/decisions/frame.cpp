#include "decisions/frame.hpp"

namespace fairlead {
namespace {

std::uint8_t check_of(const FrameHead& head) {
  return static_cast<std::uint8_t>(head[0] ^ head[1] ^ head[2] ^ head[3] ^ 0xA5U);
}

}  // namespace

FrameHead frame_head(RecordType type, std::size_t length) {
  FrameHead head{};
  head[0] = static_cast<std::uint8_t>(type);
  for (std::size_t i = 0; i < 3; ++i)
    head[1 + i] = static_cast<std::uint8_t>((length >> (8U * i)) & 0xFFU);
  head[4] = check_of(head);
  return head;
}

bool read_head(const FrameHead& head, RecordType& type, std::size_t& length) {
  type = static_cast<RecordType>(head[0]);
  length = head[1] + (std::size_t{head[2]} << 8U) + (std::size_t{head[3]} << 16U);
  return head[4] == check_of(head);
}

}  // namespace fairlead
