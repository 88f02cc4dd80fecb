#include "sim/methods/direct/links.h"

#include <algorithm>
#include <cmath>

#include "sim/methods/direct/tridiagonal.h"
#include "sim/methods/direct/vector.h"

namespace taut::direct {
namespace {

constexpr std::size_t kArrays = 23;

// A link that is turned by almost a right angle from its chart's base has left the chart.
constexpr double kLeastRoom = 1e-4;

using Out = double* __restrict;
using In = const double* __restrict;

// Each loop is written once for any number of components and compiled for two and three.

template <int kComponents>
[[gnu::always_inline]] inline void assemble_loop(std::size_t n, In q, In rate, In beside, In weight,
                                                 In apart, Out off, Out turned, Out right) {
  for (std::size_t i = 0; i < n; ++i) {
    double chord = 0, square = 0;
    for (int c = 0; c < kComponents; ++c) {
      const std::size_t at = static_cast<std::size_t>(c) * n + i;
      const double turn = q[at + 1] - q[at];
      chord += turn * turn;
      square += rate[at] * rate[at];
    }
    // A chord of length d spans an angle of cosine 1 - d^2 / 2.
    off[i] = beside[i] * (1 - chord / 2);
    turned[i] = beside[i] * beside[i] * (chord * (1 - chord / 4)) + apart[i];
    right[i] = weight[i] * square;
  }
}

template <int kComponents>
[[gnu::always_inline]] inline void pull_loop(std::size_t n, In q, In next_gain, In last_gain,
                                             In own_gain, In x, Out out) {
#pragma GCC ivdep
  for (std::size_t i = 0; i < n; ++i) {
    const double next = next_gain[i] * x[i + 1], last = last_gain[i] * x[i - 1];
    const double own = own_gain[i] * x[i];
    for (int c = 0; c < kComponents; ++c) {
      const std::size_t at = static_cast<std::size_t>(c) * n + i;
      out[at] = next * q[at + 1] + last * q[at - 1] - own * q[at];
    }
  }
}

template <int kComponents>
[[gnu::always_inline]] inline void normalise_loop(std::size_t count, std::size_t n, Out q,
                                                  Out rate) {
#pragma GCC ivdep
  for (std::size_t i = 0; i < count; ++i) {
    double square = 0, along = 0;
    for (int c = 0; c < kComponents; ++c) {
      const std::size_t at = static_cast<std::size_t>(c) * n + i;
      square += q[at] * q[at];
      along += q[at] * rate[at];
    }
    const double scale = 1 / std::sqrt(square), radial = along / square;
    for (int c = 0; c < kComponents; ++c) {
      const std::size_t at = static_cast<std::size_t>(c) * n + i;
      rate[at] -= radial * q[at];
      q[at] *= scale;
    }
  }
}

/// x = its part across b + w b with w = sqrt(1 - |x|^2); returns whether every w^2 has room.
template <int kComponents>
[[gnu::always_inline]] inline bool retract_loop(std::size_t n, In base, Out x, Out rate) {
  std::size_t outside = 0;
#pragma GCC ivdep  // components do not overlap
  for (std::size_t i = 0; i < n; ++i) {
    double x_along = 0, rate_along = 0;
    for (int c = 0; c < kComponents; ++c) {
      const std::size_t at = static_cast<std::size_t>(c) * n + i;
      x_along += x[at] * base[at];
      rate_along += rate[at] * base[at];
    }
    double square = 0, product = 0;
    for (int c = 0; c < kComponents; ++c) {
      const std::size_t at = static_cast<std::size_t>(c) * n + i;
      x[at] -= x_along * base[at];
      rate[at] -= rate_along * base[at];
      square += x[at] * x[at];
      product += x[at] * rate[at];
    }
    const double room = 1 - square;
    outside |= room > kLeastRoom ? 0 : 1;
    const double w = std::sqrt(room > kLeastRoom ? room : kLeastRoom);
    const double fall = product / w;
    for (int c = 0; c < kComponents; ++c) {
      const std::size_t at = static_cast<std::size_t>(c) * n + i;
      x[at] += w * base[at];
      rate[at] -= fall * base[at];
    }
  }
  return outside == 0;
}

template <int kComponents>
[[gnu::always_inline]] inline void to_tangent_loop(std::size_t n, In base, Out x) {
#pragma GCC ivdep
  for (std::size_t i = 0; i < n; ++i) {
    double along = 0;
    for (int c = 0; c < kComponents; ++c) {
      const std::size_t at = static_cast<std::size_t>(c) * n + i;
      along += x[at] * base[at];
    }
    for (int c = 0; c < kComponents; ++c) {
      const std::size_t at = static_cast<std::size_t>(c) * n + i;
      x[at] -= along * base[at];
    }
  }
}

TAUT_VECTOR_CLONES
void assemble_in_plane(std::size_t n, In q, In rate, In beside, In weight, In apart, Out off,
                       Out turned, Out right) {
  assemble_loop<2>(n, q, rate, beside, weight, apart, off, turned, right);
}
TAUT_VECTOR_CLONES
void assemble_in_space(std::size_t n, In q, In rate, In beside, In weight, In apart, Out off,
                       Out turned, Out right) {
  assemble_loop<3>(n, q, rate, beside, weight, apart, off, turned, right);
}
TAUT_VECTOR_CLONES
void pull_in_plane(std::size_t n, In q, In next, In last, In own, In x, Out out) {
  pull_loop<2>(n, q, next, last, own, x, out);
}
TAUT_VECTOR_CLONES
void pull_in_space(std::size_t n, In q, In next, In last, In own, In x, Out out) {
  pull_loop<3>(n, q, next, last, own, x, out);
}
TAUT_VECTOR_CLONES
void normalise_in_plane(std::size_t count, std::size_t n, Out q, Out rate) {
  normalise_loop<2>(count, n, q, rate);
}
TAUT_VECTOR_CLONES
void normalise_in_space(std::size_t count, std::size_t n, Out q, Out rate) {
  normalise_loop<3>(count, n, q, rate);
}
TAUT_VECTOR_CLONES
bool retract_in_plane(std::size_t n, In base, Out x, Out rate) {
  return retract_loop<2>(n, base, x, rate);
}
TAUT_VECTOR_CLONES
bool retract_in_space(std::size_t n, In base, Out x, Out rate) {
  return retract_loop<3>(n, base, x, rate);
}
TAUT_VECTOR_CLONES
void to_tangent_in_plane(std::size_t n, In base, Out x) {
  to_tangent_loop<2>(n, base, x);
}
TAUT_VECTOR_CLONES
void to_tangent_in_space(std::size_t n, In base, Out x) {
  to_tangent_loop<3>(n, base, x);
}

}  // namespace

void Links::reserve(std::size_t links) {
  arena_.reserve(kPad + kArrays * (links + kLanes + 2 * kPad));
}

void Links::rebuild(std::span<const Link> links, int components) {
  count_ = links.size();
  stride_ = (links.size() + kLanes - 1) / kLanes * kLanes;
  components_ = components;
  arena_.assign(kPad + kArrays * (stride_ + 2 * kPad), 0.0);
  double** const arrays[] = {
      &rest_,        &inverse_rest_,  &both_,      &shared_,   &scale_,   &beside_,
      &weight_,      &next_gain_,     &last_gain_, &own_gain_, &near_,    &far_,
      &apart_,       &turned_,        &off_,       &right_,    &unknown_, &factored_pivot_,
      &factored_up_, &factored_down_, &work_};
  static_assert(std::size(arrays) + 2 == kArrays);  // work_ is three
  for (std::size_t k = 0; k < std::size(arrays); ++k) {
    *arrays[k] = arena_.data() + kPad + k * (stride_ + 2 * kPad);
  }
  for (std::size_t i = 0; i < count_; ++i) {
    const Link& link = links[i];
    rest_[i] = link.rest;
    inverse_rest_[i] = link.rest > 0 ? 1 / link.rest : 0;
    both_[i] = link.near + link.far;
    shared_[i] = link.shares ? link.far : 0;
    const double sum = both_[i] + link.end;
    scale_[i] = sum > 0 ? std::sqrt(2 / sum) : 1;
    weight_[i] = rest_[i] * scale_[i];
    own_gain_[i] = both_[i] * scale_[i] * inverse_rest_[i];
    near_[i] = link.near * scale_[i] * scale_[i];
    far_[i] = link.far * scale_[i] * scale_[i];
  }
  for (std::size_t i = 0; i + 1 < count_; ++i) {
    beside_[i] = shared_[i] * scale_[i] * scale_[i + 1];
    next_gain_[i] = shared_[i] * scale_[i + 1] * inverse_rest_[i];
    last_gain_[i + 1] = shared_[i] * scale_[i] * inverse_rest_[i + 1];
    if (!links[i].shares) apart_[i] = far_[i] * near_[i + 1];
  }
}

void Links::assemble(const double* q, const double* rate) {
  const auto loop = components_ == 2 ? assemble_in_plane : assemble_in_space;
  loop(stride_, q + kPad, rate + kPad, beside_, weight_, apart_, off_, turned_, right_);
}

void Links::set_end(std::size_t link, bool first, double value) {
  double* side = first ? near_ : far_;
  side[link] = value * scale_[link] * scale_[link];
  if (first && link > 0) turned_[link - 1] = far_[link - 1] * near_[link];
  if (!first && link + 1 < count_) turned_[link] = far_[link] * near_[link + 1];
}

void Links::solve() {
  solve_chain(count_, near_, far_, off_, turned_, right_, unknown_, work_);
}

void Links::respond(std::size_t link, double* response) {
  std::fill(right_, right_ + count_, 0.0);
  right_[link] = scale_[link];
  solve_chain(count_, near_, far_, off_, turned_, right_, response, work_);
}

void Links::add_response(const double* response, double factor) {
  for (std::size_t i = 0; i < count_; ++i) unknown_[i] += factor * response[i];
}

void Links::pull(const double* q, double* out) {
  const auto loop = components_ == 2 ? pull_in_plane : pull_in_space;
  loop(stride_, q + kPad, next_gain_, last_gain_, own_gain_, unknown_, out + kPad);
  wave_squared_ = 2 * largest(stride_, unknown_, own_gain_);
}

void Links::factor(double sigma_squared) {
  for (std::size_t i = 0; i < count_; ++i) {
    const double pull = std::max(tension(i), 0.0);
    factored_pivot_[i] = sigma_squared * (rest_[i] > 0 ? rest_[i] : 1) + both_[i] * pull;
    factored_down_[i] = shared_[i] * pull;
    if (i > 0) factored_up_[i - 1] = shared_[i - 1] * pull;
  }
  factor_twisted(count_, factored_pivot_, factored_up_, factored_down_, work_);
}

void Links::solve_factored(double* x) const {
  for (int c = 0; c < components_; ++c) {
    double* __restrict column = x + begin(c);
    for (std::size_t i = 0; i < count_; ++i) column[i] *= rest_[i];
  }
  solve_twisted(count_, factored_pivot_, factored_up_, factored_down_, components_, stride_,
                x + kPad);
}

void Links::normalise(double* q, double* rate) const {
  const auto loop = components_ == 2 ? normalise_in_plane : normalise_in_space;
  loop(count_, stride_, q + kPad, rate + kPad);
}

bool Links::retract(const double* base, double* x, double* rate) const {
  const auto loop = components_ == 2 ? retract_in_plane : retract_in_space;
  return loop(stride_, base + kPad, x + kPad, rate + kPad);
}

void Links::to_tangent(const double* base, double* x) const {
  (components_ == 2 ? to_tangent_in_plane : to_tangent_in_space)(stride_, base + kPad, x + kPad);
}

}  // namespace taut::direct
