#include "fairlead_safety/outputs.hpp"

#include <algorithm>

namespace fairlead {

void Outputs::commit(OutputKind kind, const Name& source, std::size_t size, bool may_be_empty) {
  if (size == 0 && !may_be_empty) {
    overflowed_ = true;
    return;
  }
  if (!items_.push_back(Output{kind, source, used_, size})) {
    overflowed_ = true;
    return;
  }
  used_ += size;
}

void Outputs::add_log(std::string_view line) {
  const std::span<std::uint8_t> space = free_space();
  const std::size_t size = std::min(line.size(), space.size());
  std::copy_n(line.begin(), size, space.begin());
  commit(OutputKind::log, Name(), size, true);
}

}  // namespace fairlead
