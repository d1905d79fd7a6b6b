#include "judge_cases.hpp"

#include <cmath>
#include <cstring>
#include <stdexcept>

#include "core/modes/row_limit_check.hpp"

namespace fairlead::bench {

CopyAndCompare::CopyAndCompare(std::string name, const Limits& limits, std::uint32_t horizon)
    : Case(std::move(name)), chunk_(limits, middle_of(limits), horizon) {
  for (std::size_t i = 0; i < chunk_.numbers().size(); ++i) {
    const std::size_t j = i % limits.joints.size();
    lower_.push_back(limits.joints[j].bounds.lower);
    upper_.push_back(limits.joints[j].bounds.upper);
    step_.push_back(limits.parts[0].modes.joint_position.step_limit[j]);
  }
  copy_.resize(chunk_.numbers().size());
}

void CopyAndCompare::run(std::size_t calls) {
  const std::vector<double>& numbers = chunk_.numbers();
  const std::size_t width = numbers.size() / chunk_.chunk().horizon;
  for (std::size_t call = 0; call < calls; ++call) {
    std::memcpy(copy_.data(), numbers.data(), numbers.size() * sizeof(double));
    keep(copy_);
    std::size_t faults = 0;
    for (std::size_t i = 0; i < copy_.size(); ++i) {
      const double before = copy_[i < width ? i : i - width];
      if (!(copy_[i] >= lower_[i]) || !(copy_[i] <= upper_[i]) ||
          !(std::abs(copy_[i] - before) <= step_[i]))
        ++faults;
    }
    keep(faults);
  }
}

LimitRows::LimitRows(std::string name, const Limits& limits, std::uint32_t horizon)
    : Case(std::move(name)),
      model_(limits),
      claim_(claim_of(limits)),
      state_(middle_of(limits)),
      chunk_(limits, state_, horizon) {
  if (rows_in_order() != horizon) throw std::runtime_error(this->name() + ": a row is refused");
}

std::size_t LimitRows::rows_in_order() const {
  const RowLimitCheck walk{model_, claim_, state_, chunk_.chunk(), 0, nothing_before_};
  std::size_t row = 0;
  while (row < chunk_.chunk().horizon && walk.check(row).ok()) ++row;
  return row;
}

void LimitRows::run(std::size_t calls) {
  for (std::size_t call = 0; call < calls; ++call) {
    const std::size_t rows = rows_in_order();
    keep(rows);
  }
}

WholeRows::WholeRows(std::string name, const Limits& limits, std::uint32_t horizon)
    : Case(std::move(name)),
      model_(limits),
      claim_(claim_of(limits)),
      state_(middle_of(limits)),
      chunk_(limits, state_, horizon) {
  const Judgement found =
      judge_rows(room_, model_, claim_, state_, chunk_.chunk(), all_rows(), RowBefore{}, {});
  if (found.row_count == horizon) return;
  std::string place = this->name();
  place.append(": row ").append(std::to_string(found.evidence.row)).append(" is refused: G");
  place.append(std::to_string(found.evidence.code)).append(" ").append(found.evidence.axis);
  throw std::runtime_error(place);
}

JudgedRows WholeRows::all_rows() const { return JudgedRows::all(0, chunk_.chunk().horizon); }

void WholeRows::run(std::size_t calls) {
  for (std::size_t call = 0; call < calls; ++call) {
    const Judgement found =
        judge_rows(room_, model_, claim_, state_, chunk_.chunk(), all_rows(), RowBefore{}, {});
    keep(found);
  }
}

}  // namespace fairlead::bench
