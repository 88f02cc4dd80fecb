#include "sim/methods/direct/kernels.h"

#include <cmath>

#include "sim/methods/direct/vector.h"

namespace taut::direct::kernels {
namespace {

using Out = double* __restrict;
using In = const double* __restrict;

template <int D>
[[gnu::always_inline]] inline void directions_loop(std::size_t n, In q, In inverse_rest, Out u) {
#pragma GCC ivdep
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t c = 0; c < D; ++c) {
      u[c * n + i] = (q[c * n + i + 1] - q[c * n + i]) * inverse_rest[i];
    }
  }
}

template <int D>
[[gnu::always_inline]] inline void neighbours_loop(std::size_t n, In u, In beside, In apart,
                                                   Out off, Out turned) {
  for (std::size_t i = 0; i < n; ++i) {
    double chord = 0;
    for (std::size_t c = 0; c < D; ++c) {
      const double turn = u[c * n + i + 1] - u[c * n + i];
      chord += turn * turn;
    }
    // A chord of length d spans an angle of cosine 1 - d^2 / 2, without the rounding of u . u.
    off[i] = beside[i] * (1 - chord / 2);
    turned[i] = beside[i] * beside[i] * (chord * (1 - chord / 4)) + apart[i];
  }
}

template <int D>
[[gnu::always_inline]] inline void centripetal_loop(std::size_t n, In v, In inverse_rest, In weight,
                                                    Out right) {
  for (std::size_t i = 0; i < n; ++i) {
    double square = 0;
    for (std::size_t c = 0; c < D; ++c) {
      const double rate = (v[c * n + i + 1] - v[c * n + i]) * inverse_rest[i];
      square += rate * rate;
    }
    right[i] = weight[i] * square;
  }
}

template <int D>
[[gnu::always_inline]] inline double excess_loop(std::size_t n, In u, In weight, Out right) {
  for (std::size_t i = 0; i < n; ++i) {
    double square = 0;
    for (std::size_t c = 0; c < D; ++c) square += u[c * n + i] * u[c * n + i];
    // |u| - 1 without the rounding of the root; nothing where there is no link.
    right[i] = weight[i] > 0 ? (square - 1) / (1 + std::sqrt(square)) : 0;
  }
  const double most = largest(n, right);
  for (std::size_t i = 0; i < n; ++i) right[i] *= weight[i];
  return most;
}

template <int D>
[[gnu::always_inline]] inline void lengthening_loop(std::size_t n, In u, In v, In inverse_rest,
                                                    In weight, Out right) {
  for (std::size_t i = 0; i < n; ++i) {
    double along = 0;
    for (std::size_t c = 0; c < D; ++c) {
      along += u[c * n + i] * (v[c * n + i + 1] - v[c * n + i]);
    }
    right[i] = weight[i] * inverse_rest[i] * along;
  }
}

template <int D>
[[gnu::always_inline]] inline void pull_loop(std::size_t n, In u, In x, In after, In before,
                                             In falls, In g, Out out) {
#pragma GCC ivdep
  for (std::size_t i = 0; i < n; ++i) {
    const double next = after[i] * x[i], last = before[i] * x[i - 1];
    for (std::size_t c = 0; c < D; ++c) {
      out[c * n + i] = next * u[c * n + i] - last * u[c * n + i - 1] + falls[i] * g[c];
    }
  }
}

template <int D>
[[gnu::always_inline]] inline void push_loop(std::size_t n, In u, In x, In after, In before,
                                             Out out) {
#pragma GCC ivdep
  for (std::size_t i = 0; i < n; ++i) {
    const double next = after[i] * x[i], last = before[i] * x[i - 1];
    for (std::size_t c = 0; c < D; ++c) {
      out[c * n + i] += next * u[c * n + i] - last * u[c * n + i - 1];
    }
  }
}

template <int D>
[[gnu::always_inline]] inline double shake_loop(std::size_t n, double per_square, In weight, In d,
                                                Out right) {
#pragma GCC ivdep
  for (std::size_t i = 0; i < n; ++i) {
    double length = 0;
    for (std::size_t c = 0; c < D; ++c) length += d[c * n + i] * d[c * n + i];
    right[i] = weight[i] > 0 ? (length - 1) / 2 : 0;
  }
  const double most = largest(n, right);
  for (std::size_t i = 0; i < n; ++i) right[i] *= weight[i] * per_square;
  return most;
}

// Each loop is compiled for two and for three axes, with clones for more than one processor.
#define TAUT_BOTH(result, name, parameters, arguments) \
  TAUT_VECTOR_CLONES result name##_2 parameters {      \
    return name##_loop<2> arguments;                   \
  }                                                    \
  TAUT_VECTOR_CLONES result name##_3 parameters {      \
    return name##_loop<3> arguments;                   \
  }

TAUT_BOTH(void, directions, (std::size_t n, In q, In r, Out u), (n, q, r, u))
TAUT_BOTH(void, neighbours, (std::size_t n, In u, In b, In a, Out o, Out t), (n, u, b, a, o, t))
TAUT_BOTH(void, centripetal, (std::size_t n, In v, In r, In w, Out o), (n, v, r, w, o))
TAUT_BOTH(double, excess, (std::size_t n, In u, In w, Out o), (n, u, w, o))
TAUT_BOTH(void, lengthening, (std::size_t n, In u, In v, In r, In w, Out o), (n, u, v, r, w, o))
TAUT_BOTH(void, pull, (std::size_t n, In u, In x, In a, In b, In f, In g, Out o),
          (n, u, x, a, b, f, g, o))
TAUT_BOTH(void, push, (std::size_t n, In u, In x, In a, In b, Out o), (n, u, x, a, b, o))
TAUT_BOTH(double, shake, (std::size_t n, double p, In w, In d, Out o), (n, p, w, d, o))
#undef TAUT_BOTH

}  // namespace

void directions(int axes, std::size_t n, const double* q, const double* inverse_rest, double* u) {
  (axes == 2 ? directions_2 : directions_3)(n, q, inverse_rest, u);
}

void neighbours(int axes, std::size_t n, const double* u, const double* beside, const double* apart,
                double* off, double* turned) {
  (axes == 2 ? neighbours_2 : neighbours_3)(n, u, beside, apart, off, turned);
}

void centripetal(int axes, std::size_t n, const double* v, const double* inverse_rest,
                 const double* weight, double* right) {
  (axes == 2 ? centripetal_2 : centripetal_3)(n, v, inverse_rest, weight, right);
}

double excess(int axes, std::size_t n, const double* u, const double* weight, double* right) {
  return (axes == 2 ? excess_2 : excess_3)(n, u, weight, right);
}

void lengthening(int axes, std::size_t n, const double* u, const double* v,
                 const double* inverse_rest, const double* weight, double* right) {
  (axes == 2 ? lengthening_2 : lengthening_3)(n, u, v, inverse_rest, weight, right);
}

void pull(int axes, std::size_t n, const double* u, const double* x, const double* after,
          const double* before, const double* falls, const double* g, double* out) {
  (axes == 2 ? pull_2 : pull_3)(n, u, x, after, before, falls, g, out);
}

void push(int axes, std::size_t n, const double* u, const double* x, const double* after,
          const double* before, double* out) {
  (axes == 2 ? push_2 : push_3)(n, u, x, after, before, out);
}

double shake(int axes, std::size_t n, double per_square, const double* weight, const double* d,
             double* right) {
  return (axes == 2 ? shake_2 : shake_3)(n, per_square, weight, d, right);
}

double steepest(int axes, std::size_t n, const double* x, const double* inverse_rest) {
  double most = 0;
  for (std::size_t c = 0; c < static_cast<std::size_t>(axes); ++c) {
    for (std::size_t i = 0; i < n; ++i) {
      most = std::max(most, std::abs(x[c * n + i + 1] - x[c * n + i]) * inverse_rest[i]);
    }
  }
  return most;
}

TAUT_VECTOR_CLONES
void hermite(std::size_t n, double h, double s, const double* q0, const double* v0,
             const double* q1, const double* v1, double* __restrict q, double* __restrict v) {
  for (std::size_t i = 0; i < n; ++i) {
    const double start = h * v0[i], end = h * v1[i], gone = q1[i] - q0[i];
    const double c2 = 3 * gone - 2 * start - end, c3 = start + end - 2 * gone;
    q[i] = q0[i] + s * (start + s * (c2 + s * c3));
    v[i] = (start + s * (2 * c2 + s * 3 * c3)) / h;
  }
}

TAUT_VECTOR_CLONES
void add(std::size_t n, double factor, const double* __restrict x, double* __restrict y) {
  for (std::size_t i = 0; i < n; ++i) y[i] += factor * x[i];
}

TAUT_VECTOR_CLONES
double squares(std::size_t n, const double* x) {
  double lane[kLanes] = {};
  for (std::size_t i = 0; i < n; i += kLanes) {
    for (std::size_t j = 0; j < kLanes; ++j) lane[j] += x[i + j] * x[i + j];
  }
  return (lane[0] + lane[1]) + (lane[2] + lane[3]);
}

}  // namespace taut::direct::kernels
