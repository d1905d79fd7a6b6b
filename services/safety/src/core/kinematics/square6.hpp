// Symmetric six by six matrices, as damped least squares needs them: small enough to be written
// out, which is several times as fast as code for any size; unrolled, three times as fast again.
#pragma once

#include <Eigen/Core>

namespace fairlead {

using Motion6 = Eigen::Matrix<double, 6, 1>;
using Square6 = Eigen::Matrix<double, 6, 6>;

/// The factors of L D L^T, L with ones on its diagonal, of which only the lower half of the matrix
/// is read.
class Factors6 {
 public:
  explicit Factors6(const Square6& matrix) : lower_(matrix) {
#pragma GCC unroll 6
    for (int j = 0; j < 6; ++j) {
      const double pivot = lower_(j, j);
      definite_ = definite_ && pivot > 0.0;  // also false for what is no number
      inverse_[j] = 1.0 / pivot;
#pragma GCC unroll 6
      for (int i = j + 1; i < 6; ++i) {
        const double share = lower_(i, j) * inverse_[j];
#pragma GCC unroll 6
        for (int k = j + 1; k <= i; ++k) lower_(i, k) -= share * lower_(k, j);
      }
#pragma GCC unroll 6
      for (int i = j + 1; i < 6; ++i) lower_(i, j) *= inverse_[j];
    }
  }

  /// Whether the matrix is positive definite.
  [[nodiscard]] bool definite() const { return definite_; }

  /// The solution of matrix * x = right.
  [[nodiscard]] Motion6 solve(const Motion6& right) const {
    Motion6 x = right;
#pragma GCC unroll 6
    for (Eigen::Index j = 0; j != x.size(); ++j) {
#pragma GCC unroll 6
      for (Eigen::Index i = j + 1; i < 6; ++i) x[i] -= lower_(i, j) * x[j];
      x[j] *= inverse_[j];
    }
#pragma GCC unroll 6
    for (int j = 5; j != 0; --j)
#pragma GCC unroll 6
      for (int i = 0; i < j; ++i) x[i] -= lower_(j, i) * x[j];
    return x;
  }

 private:
  Square6 lower_;
  Motion6 inverse_;  // of D
  bool definite_ = true;
};

}  // namespace fairlead
