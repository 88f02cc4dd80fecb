#include "scenes/character/track.h"

#include <algorithm>
#include <cmath>

namespace taut::scenes {

Track Track::sample(double duration, double rate,
                    const std::function<Eigen::VectorXd(double)>& value) {
  const auto count = static_cast<Eigen::Index>(std::ceil(duration * rate)) + 1;
  Eigen::MatrixXd samples(value(0).size(), count);
  for (Eigen::Index i = 0; i < count; ++i) samples.col(i) = value(static_cast<double>(i) / rate);
  return {std::move(samples), rate};
}

Eigen::Index Track::nearest(Eigen::Index i) const {
  return std::clamp<Eigen::Index>(i, 0, count() - 1);
}

/// Catmull and Rom's spline: through each sample with the rate of its neighbours' chord.
Eigen::VectorXd Track::at(double time) const {
  const double x = std::clamp(time * rate_, 0.0, static_cast<double>(count() - 1));
  const auto i = static_cast<Eigen::Index>(x);
  const double u = x - static_cast<double>(i), u2 = u * u, u3 = u2 * u;
  const auto p = [&](Eigen::Index k) { return samples_.col(nearest(i + k)); };
  return 0.5 * ((-u3 + 2 * u2 - u) * p(-1) + (3 * u3 - 5 * u2 + 2) * p(0) +
                (-3 * u3 + 4 * u2 + u) * p(1) + (u3 - u2) * p(2));
}

/// x'' = w^2 (value - x) - 2 w x' has the mean delay 2/w. Between samples the value is taken as
/// linear, for which e = x - value, d = e' + w e is solved exactly.
Track Track::lagged(double lag) const {
  const double w = 2 / lag, dt = 1 / rate_, decay = std::exp(-w * dt);
  Track out = *this;
  Eigen::VectorXd x = samples_.col(0), v = Eigen::VectorXd::Zero(x.size());
  for (Eigen::Index i = 1; i < count(); ++i) {
    const Eigen::VectorXd slope = (samples_.col(i) - samples_.col(i - 1)) * rate_;
    // On a ramp the follower tends to the ramp, 2/w behind.
    const Eigen::VectorXd e = x - (samples_.col(i - 1) - 2 / w * slope);
    const Eigen::VectorXd d = (v - slope) + w * e;
    x = samples_.col(i) - 2 / w * slope + decay * (e + dt * d);
    v = slope + decay * (v - slope - w * dt * d);
    out.samples_.col(i) = x;
  }
  return out;
}

Track Track::smoothed(double deviation) const {
  const double width = deviation * rate_;
  const auto radius = static_cast<Eigen::Index>(std::ceil(3.5 * width));
  Eigen::VectorXd kernel(radius + 1);
  for (Eigen::Index k = 0; k <= radius; ++k)
    kernel[k] = std::exp(-0.5 * std::pow(static_cast<double>(k) / width, 2));
  kernel /= kernel[0] + 2 * kernel.tail(radius).sum();
  Track out = *this;
  for (Eigen::Index i = 0; i < count(); ++i) {
    Eigen::VectorXd sum = kernel[0] * samples_.col(i);
    for (Eigen::Index k = 1; k <= radius; ++k)
      sum += kernel[k] * (samples_.col(nearest(i - k)) + samples_.col(nearest(i + k)));
    out.samples_.col(i) = sum;
  }
  return out;
}

Track Track::rates() const {
  Track out = *this;
  for (Eigen::Index i = 0; i < count(); ++i)
    out.samples_.col(i) =
        (samples_.col(nearest(i + 1)) - samples_.col(nearest(i - 1))) * (rate_ / 2);
  return out;
}

Track Track::ahead(double shift) const {
  Track out = *this;
  for (Eigen::Index i = 0; i < count(); ++i) out.samples_.col(i) = at(time(i) + shift);
  return out;
}

}  // namespace taut::scenes
