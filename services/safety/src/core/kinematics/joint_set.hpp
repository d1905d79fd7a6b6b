// The joints of a set one by one.
#pragma once

#include <bit>
#include <cstddef>

#include "core/kinematics/robot_model.hpp"

namespace fairlead {

/// `for (const std::size_t joint : JointsIn(set))`: in order of their index.
class JointsIn {
 public:
  explicit JointsIn(JointSet set) : left_(set) {}

  class Iterator {
   public:
    explicit Iterator(JointSet left) : left_(left) {}
    std::size_t operator*() const { return static_cast<std::size_t>(std::countr_zero(left_)); }
    Iterator& operator++() {
      left_ ^= only(**this);
      return *this;
    }
    bool operator==(const Iterator& other) const = default;

   private:
    JointSet left_;
  };

  [[nodiscard]] Iterator begin() const { return Iterator(left_); }
  [[nodiscard]] static Iterator end() { return Iterator(JointSet{}); }

 private:
  JointSet left_;
};

}  // namespace fairlead
