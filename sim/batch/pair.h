// Two vectors side by side as one: while one of them waits for its last result, the other goes on.
#pragma once

namespace taut::batch {

template <typename V>
struct Pair {
  V a, b;

  friend Pair operator+(const Pair& x, const Pair& y) { return {x.a + y.a, x.b + y.b}; }
  friend Pair operator-(const Pair& x, const Pair& y) { return {x.a - y.a, x.b - y.b}; }
  friend Pair operator*(const Pair& x, const Pair& y) { return {x.a * y.a, x.b * y.b}; }
  template <typename Scalar>
  friend Pair operator*(Scalar x, const Pair& y) {
    return {x * y.a, x * y.b};
  }
  template <typename Scalar>
  friend Pair operator/(Scalar x, const Pair& y) {
    return {x / y.a, x / y.b};
  }
  template <typename Scalar>
  friend Pair operator-(const Pair& x, Scalar y) {
    return {x.a - y, x.b - y};
  }
  Pair operator-() const { return {-a, -b}; }
  Pair& operator+=(const Pair& x) { return *this = *this + x; }
};

}  // namespace taut::batch
