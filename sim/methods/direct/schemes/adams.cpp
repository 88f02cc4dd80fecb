#include "sim/methods/direct/schemes/adams.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "sim/methods/direct/system/links.h"

namespace taut::direct {
namespace {

using Out = double* __restrict;
using In = const double* __restrict;

/// A sum that vector code can add to.
struct Lanes {
  double lane[kLanes] = {};
  double sum() const { return (lane[0] + lane[1]) + (lane[2] + lane[3]); }
};

constexpr std::size_t kNeeded = 4;

// Polynomials through accelerations, integrated over a step: for q twice, through the last three;
// for its rate once, ahead of the step through the same, then with the one at its end and a fourth.
// Hairer, Norsett and Wanner, Solving Ordinary Differential Equations I, III.1, III.10.
constexpr double kPlace[3] = {19.0 / 24, -10.0 / 24, 3.0 / 24};
constexpr double kRate[5] = {251.0 / 720, 646.0 / 720, -264.0 / 720, 106.0 / 720, -19.0 / 720};
/// The rate ahead takes half of the third difference that a polynomial through four would: so it is
/// nearly as accurate and stirs fast waves less.
constexpr double kThird = 3.0 / 16;
constexpr double kRateAhead[4] = {23.0 / 12 + kThird, -16.0 / 12 - 3 * kThird,
                                  5.0 / 12 + 3 * kThird, -kThird};
/// The estimated error of the rate, in units of h times the fourth difference. The error of q,
/// 38/360 h^2 times the third, counts for waves as a fifth of this; that of the rate ahead counts
/// for more in links that turn.
constexpr double kError = 0.5;

/// Leaves in x how far q goes.
TAUT_VECTOR_CLONES
void predict(std::size_t n, double h, In rate, In a, In b, In c, In d, Out x, Out rate_out) {
  const double h2 = h * h;
  for (std::size_t i = 0; i < n; ++i) {
    x[i] = h * rate[i] + h2 * (kPlace[0] * a[i] + kPlace[1] * b[i] + kPlace[2] * c[i]);
    rate_out[i] = rate[i] + h * (kRateAhead[0] * a[i] + kRateAhead[1] * b[i] +
                                 kRateAhead[2] * c[i] + kRateAhead[3] * d[i]);
  }
}

/// Writes the rate and its error; returns the sum of the squares of that.
TAUT_VECTOR_CLONES
double correct(std::size_t n, double h, In rate, In next, In a, In b, In c, In d, Out rate_out,
               Out error) {
  const double scale = kError * h;
  for (std::size_t i = 0; i < n; ++i) {
    rate_out[i] = rate[i] + h * ((kRate[0] * next[i] + kRate[1] * a[i]) +
                                 (kRate[2] * b[i] + kRate[3] * c[i]) + kRate[4] * d[i]);
    error[i] = scale * ((next[i] + d[i]) - 4 * (a[i] + c[i]) + 6 * b[i]);
  }
  Lanes squares;
  for (std::size_t i = 0; i < n; i += kLanes) {
    for (std::size_t j = 0; j < kLanes; ++j) squares.lane[j] += error[i + j] * error[i + j];
  }
  return squares.sum();
}

using Weights = std::array<double, AdamsStep::kKept>;

/// The weights of Lagrange's polynomial through 0, 1, ... points - 1, at x; zero beyond.
Weights lagrange(std::size_t points, double x) {
  constexpr double kFactorial[AdamsStep::kKept] = {1, 1, 2, 6, 24, 120};
  double below[AdamsStep::kKept + 1], above[AdamsStep::kKept + 1];  // products of x - k, k - x
  below[0] = above[points] = 1;
  for (std::size_t k = 0; k < points; ++k) below[k + 1] = below[k] * (x - static_cast<double>(k));
  for (std::size_t k = points; k-- > 0;) above[k] = above[k + 1] * (static_cast<double>(k) - x);
  Weights weight{};
  for (std::size_t k = 0; k < points; ++k) {
    weight[k] = below[k] * above[k + 1] / (kFactorial[k] * kFactorial[points - 1 - k]);
  }
  return weight;
}

TAUT_VECTOR_CLONES
void interpolate(std::size_t n, const Weights& w, const std::array<Slice, 6>& a, Out out) {
  In a0 = a[0].data(), a1 = a[1].data(), a2 = a[2].data();
  In a3 = a[3].data(), a4 = a[4].data(), a5 = a[5].data();
  for (std::size_t i = 0; i < n; ++i) {
    out[i] = ((w[0] * a0[i] + w[1] * a1[i]) + (w[2] * a2[i] + w[3] * a3[i])) +
             (w[4] * a4[i] + w[5] * a5[i]);
  }
}

}  // namespace

void AdamsStep::make_arrays(Arena& arena) {
  known_ = 0;
  h_ = 0;
  for (auto* list : {&past_, &spare_}) {
    for (Slice& slice : *list) {
      slice = arena.make();
      std::ranges::fill(slice, 0.0);  // interpolate() gives weight zero to what is not known
    }
  }
  for (Slice* slice : {&next_, &q_, &rate_, &error_}) *slice = arena.make();
}

std::array<double*, 4> AdamsStep::begin(double h) {
  known_ = kNeeded;
  h_ = h;
  return {past_[0].data(), past_[1].data(), past_[2].data(), past_[3].data()};
}

void AdamsStep::accept() {
  std::rotate(past_.begin(), past_.end() - 1, past_.end());
  std::swap(past_[0], next_);
  known_ = std::min(known_ + 1, kKept);
}

double AdamsStep::longest() const {
  if (known_ < kNeeded) return 0;
  return static_cast<double>(known_ - 1) / static_cast<double>(kNeeded - 1) * h_;
}

bool AdamsStep::prepare(double h) {
  if (!(h <= longest() * (1 + 1e-9))) return false;
  if (std::abs(h - h_) > 1e-9 * h) respace(h);
  return true;
}

/// Interpolates the accelerations at a new spacing, as far as they reach.
void AdamsStep::respace(double h) {
  const double ratio = h / h_;
  const auto spacings = static_cast<std::size_t>(static_cast<double>(known_ - 1) / ratio + 1e-9);
  const std::size_t kept = std::min(spacings + 1, kKept);
  for (std::size_t j = 1; j < kept; ++j) {
    const auto weight = lagrange(known_, static_cast<double>(j) * ratio);
    interpolate(next_.size(), weight, past_, spare_[j].data());
  }
  for (std::size_t j = 1; j < kept; ++j) std::swap(past_[j], spare_[j]);
  known_ = kept;
  h_ = h;
}

/// q goes through the chart, since accelerations remembered from other directions lead off the unit
/// lengths: the motion's response to that would come back by way of the next ones and grow.
double AdamsStep::attempt(System& system, double time, const double* q, const double* rate,
                          double unimportant) {
  constexpr double kOutside = std::numeric_limits<double>::infinity();
  const std::size_t size = q_.size();
  const double *a = past(0), *b = past(1), *c = past(2), *d = past(3);
  predict(size, h_, rate, a, b, c, d, q_.data(), rate_.data());
  if (!system.retract(q, q_.data(), rate_.data())) return kOutside;
  system.acceleration(time + h_, q_.data(), rate_.data(), next_.data());
  const double squares =
      correct(size, h_, rate, next_.data(), a, b, c, d, rate_.data(), error_.data());
  const double bound = system.velocity_time() * system.displacement_bound(squares);
  return bound < unimportant ? bound : system.velocity_time() * system.displacement(error_.data());
}

}  // namespace taut::direct
