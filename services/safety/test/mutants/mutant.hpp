// Every mutation of the core, behind a number: bench/mutants writes calls of these into copies of
// the core's sources, and one run of the tests has one of them switched on.
//
// Operators are replaced by a detour of the same precedence, so nothing has to be parsed:
// `a < b` becomes `a < fm::Less{17} < b`. Never part of the product.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string_view>
#include <type_traits>

// Tests that include a header of the core are compiled as strictly as always.
#pragma GCC diagnostic ignored "-Wconversion"
#pragma GCC diagnostic ignored "-Wsign-conversion"
#pragma GCC diagnostic ignored "-Wshadow"
#pragma GCC diagnostic ignored "-Wpedantic"
#pragma GCC diagnostic ignored "-Wextra"
#pragma GCC diagnostic ignored "-Wall"

namespace fm {

inline constexpr unsigned most = 100'000;
extern unsigned active;     // the mutant of this process, 0: none
extern bool reached[most];  // which ones the running test has come by

inline bool on(unsigned id) {
  reached[id] = true;
  return active == id;
}

/// A condition, negated by its mutant.
template <class T>
bool flip(unsigned id, const T& value) {
  return on(id) != static_cast<bool>(value);
}

/// A check that its mutant does not ask: it finds nothing.
template <class Check>
auto ask(unsigned id, const Check& check) {
  return on(id) ? decltype(check()){} : check();
}

/// A number that is wrong by as much as matters: 5 is 6, 4096 and 0.5 are twice as much, 0.0 is 1,
/// and a tolerance (below 1e-4) is a million times as wide.
template <class T>
T number(unsigned id, T value) {
  if (!on(id)) return value;
  if constexpr (std::is_same_v<T, bool>) {
    return !value;
  } else if constexpr (std::is_integral_v<T>) {
    return static_cast<T>(value < T{100} ? value + 1 : value * 2);
  } else {
    return value == T{} ? T{1} : value * (std::abs(value) < T{1e-4} ? T{1e6} : T{2});
  }
}

template <class T>
T least(unsigned id, const std::type_identity_t<T>& a, const std::type_identity_t<T>& b) {
  return on(id) ? std::max<T>(a, b) : std::min<T>(a, b);
}
template <class T>
T most_of(unsigned id, const std::type_identity_t<T>& a, const std::type_identity_t<T>& b) {
  return on(id) ? std::min<T>(a, b) : std::max<T>(a, b);
}
template <class T>
T magnitude(unsigned id, T value) {
  return on(id) ? value : std::abs(value);
}
inline double sine(unsigned id, double x) { return on(id) ? std::cos(x) : std::sin(x); }
inline double cosine(unsigned id, double x) { return on(id) ? std::sin(x) : std::cos(x); }

// The tags that stand between two operands; id, and id + 1 where there are two mutants.
struct Compare {
  unsigned id;
};
struct Equal {
  unsigned id;
};
struct Sum {
  unsigned id;
};
struct Product {
  unsigned id;
};
struct Not {
  unsigned id;
};

template <class T>
bool operator->*(Not tag, const T& value) {
  return on(tag.id) == static_cast<bool>(value);
}

template <class A, int kind>
struct Left {
  const A& value;
  unsigned id;
};

// What is true of each element of an array has a type of its own.
#define FM_COMPARE(op, moved, kind)                                                    \
  template <class A>                                                                   \
  Left<A, kind> operator op(const A & a, Compare tag) {                                \
    return {a, tag.id};                                                                \
  }                                                                                    \
  template <class A, class B>                                                          \
  auto operator op(Left<A, kind> left, const B& b) {                                   \
    const bool boundary = on(left.id), negated = on(left.id + 1);                      \
    if constexpr (requires { (left.value op b).eval(); }) {                            \
      using Result = std::remove_cvref_t<decltype((left.value op b).eval())>;          \
      const Result plain = left.value op b;                                            \
      return boundary ? Result(left.value moved b) : negated ? Result(!plain) : plain; \
    } else {                                                                           \
      return boundary ? left.value moved b : (left.value op b) != negated;             \
    }                                                                                  \
  }
FM_COMPARE(<, <=, 0)
FM_COMPARE(<=, <, 1)
FM_COMPARE(>, >=, 2)
FM_COMPARE(>=, >, 3)
#undef FM_COMPARE

#define FM_EQUAL(op, kind)                                                    \
  template <class A>                                                          \
  Left<A, kind> operator op(const A & a, Equal tag) {                         \
    return {a, tag.id};                                                       \
  }                                                                           \
  template <class A, class B>                                                 \
  auto operator op(Left<A, kind> left, const B& b) {                          \
    const bool other = on(left.id);                                           \
    if constexpr (requires { (left.value op b).eval(); }) {                   \
      using Result = std::remove_cvref_t<decltype((left.value op b).eval())>; \
      const Result plain = left.value op b;                                   \
      return other ? Result(!plain) : plain;                                  \
    } else {                                                                  \
      return (left.value op b) != other;                                      \
    }                                                                         \
  }
FM_EQUAL(==, 4)
FM_EQUAL(!=, 5)
#undef FM_EQUAL

// Sums of vectors are lazy: their value is taken before an operand goes out of scope.
#define FM_SUM(op, other, kind)                                  \
  template <class A>                                             \
  Left<A, kind> operator op(const A & a, Sum tag) {              \
    return {a, tag.id};                                          \
  }                                                              \
  template <class A, class B>                                    \
  auto operator op(Left<A, kind> left, const B& b) {             \
    const A& a = left.value;                                     \
    if constexpr (requires { (a op b).eval(); })                 \
      return on(left.id) ? (a other b).eval() : (a op b).eval(); \
    else if constexpr (requires { a other b; })                  \
      return on(left.id) ? a other b : a op b;                   \
    else                                                         \
      return on(left.id) ? (a op b) + 1 : a op b;                \
  }
FM_SUM(+, -, 6)
FM_SUM(-, +, 7)
#undef FM_SUM

template <class A>
Left<A, 8> operator*(const A& a, Product tag) {
  return {a, tag.id};
}
template <class One, class Other>
constexpr bool same_shape = int{One::RowsAtCompileTime} == int{Other::RowsAtCompileTime} &&
                            int{One::ColsAtCompileTime} == int{Other::ColsAtCompileTime};
// Numbers are divided, rotations put in the other order, and what they turn is left as it is; a
// product of another shape than what is multiplied has its sign turned.
template <class A, class B>
auto operator*(Left<A, 8> left, const B& b) {
  const A& a = left.value;
  if constexpr (std::is_arithmetic_v<A> && std::is_arithmetic_v<B>) {
    return on(left.id) ? a / b : a * b;
  } else if constexpr (requires {
                         a.coeffs();
                         b.coeffs();
                       }) {
    return on(left.id) ? b * a : a * b;
  } else if constexpr (!requires { (a * b).eval(); }) {
    using Result = decltype(a * b);
    return on(left.id) ? Result(a) : Result(a * b);
  } else {
    using Result = std::remove_cvref_t<decltype((a * b).eval())>;
    if constexpr (std::is_arithmetic_v<B>)
      return on(left.id) ? Result(a) : Result(a * b);
    else if constexpr (same_shape<Result, B>)
      return on(left.id) ? Result(b) : Result(a * b);
    else
      return on(left.id) ? Result(-(a * b)) : Result(a * b);
  }
}
template <class A>
Left<A, 9> operator/(const A& a, Product tag) {
  return {a, tag.id};
}
template <class A, class B>
auto operator/(Left<A, 9> left, const B& b) {
  if constexpr (requires { (left.value / b).eval(); })
    return on(left.id) ? (left.value * b).eval() : (left.value / b).eval();
  else
    return on(left.id) ? left.value * b : left.value / b;
}

}  // namespace fm
