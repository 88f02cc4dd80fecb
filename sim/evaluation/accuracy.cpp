#include "sim/evaluation/accuracy.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace taut::study {
namespace {

/// Of every particle, how far along the connector it is, as a share of the length.
std::vector<double> shares(const std::vector<Vec3>& particles) {
  std::vector<double> along{0};
  for (std::size_t i = 1; i < particles.size(); ++i) {
    along.push_back(along.back() + (particles[i] - particles[i - 1]).norm());
  }
  if (const double length = along.back(); length > 0) {
    for (double& share : along) share /= length;
  }
  return along;
}

}  // namespace

SamplePoints::SamplePoints(const World& world, const Snapshot& start) {
  for (const auto& particles : start.connectors) along_.push_back(shares(particles));
  for (const Connector& connector : world.connectors) running_.push_back({connector.winch, {}, {}});
  running_.resize(along_.size());
  for (std::size_t p = 0; p < world.pulleys.size(); ++p) {
    running_[world.pulleys[p].from].leaves.push_back(p);
    running_[world.pulleys[p].to].enters.push_back(p);
  }
  for (const Body& body : world.bodies) {
    const std::array<Vec3, 6> ends = box_ends(body.bare);
    ends_.emplace_back(ends.begin(), ends.end());
  }
}

std::vector<double> SamplePoints::along(std::size_t connector, const Snapshot& state) const {
  const Running& running = running_[connector];
  if (!running.winch) return along_[connector];
  const Winch& winch = *running.winch;
  double longer = winch.longer(state.time).length;
  for (const std::size_t p : running.enters) longer += state.passed.at(p);
  for (const std::size_t p : running.leaves) longer -= state.passed.at(p);
  std::vector<double> along{0};
  for (std::size_t k = 0; k < winch.rest.size(); ++k) {
    along.push_back(along.back() + winch.rest[k] + winch.share(k) * longer);
  }
  const double length = along.back();
  for (double& share : along) share /= length;
  return along;
}

std::vector<Vec3> SamplePoints::places(const SamplePoints& of, const Snapshot& state) const {
  if (along_.size() != of.along_.size() || ends_.size() != of.ends_.size()) {
    throw std::invalid_argument("motions of different worlds cannot be compared");
  }
  std::vector<Vec3> places;
  for (std::size_t c = 0; c < along_.size(); ++c) {
    const std::vector<double> along = this->along(c, state), others = of.along(c, state);
    const std::vector<Vec3>& particles = state.connectors[c];
    std::size_t link = 0;
    for (const double share : others) {
      while (link + 2 < along.size() && along[link + 1] < share) ++link;
      const double length = along[link + 1] - along[link];
      const double part = length > 0 ? std::clamp((share - along[link]) / length, 0.0, 1.0) : 0;
      places.push_back(particles[link] + part * (particles[link + 1] - particles[link]));
    }
  }
  for (std::size_t b = 0; b < ends_.size(); ++b) {
    for (const Vec3& end : of.ends_[b]) places.push_back(state.bodies[b].to_world(end));
  }
  return places;
}

namespace {

struct Sum {
  double squares = 0;
  std::size_t count = 0;

  void add(const Snapshot& frame, const Snapshot& truth, const Distance& distance) {
    if (frame.connectors.size() != truth.connectors.size()) {
      throw std::invalid_argument("frames of different worlds cannot be compared");
    }
    for (std::size_t c = 0; c < frame.connectors.size(); ++c) {
      if (frame.connectors[c].size() != truth.connectors[c].size()) {
        throw std::invalid_argument("connectors of different lengths cannot be compared");
      }
      for (std::size_t i = 0; i < frame.connectors[c].size(); ++i) {
        const double d = distance(frame.connectors[c][i], truth.connectors[c][i], truth.time);
        squares += d * d;
        ++count;
      }
    }
  }
  double root() const { return count ? std::sqrt(squares / static_cast<double>(count)) : 0; }
};

}  // namespace

Metric share_of_length(double length) {
  return {"share of the length", "1", [length](const Vec3& at, const Vec3& truth, double) {
            return (at - truth).norm() / length;
          }};
}

double rms_error(std::span<const Snapshot> frames, std::span<const Snapshot> truth, double horizon,
                 const Distance& distance) {
  Sum sum;
  for (std::size_t k = 0; k < truth.size() && truth[k].time <= horizon; ++k) {
    if (k >= frames.size()) return std::numeric_limits<double>::infinity();
    sum.add(frames[k], truth[k], distance);
  }
  return sum.root();
}

double frame_error(const Snapshot& frame, const Snapshot& truth, const Distance& distance) {
  Sum sum;
  sum.add(frame, truth, distance);
  return sum.root();
}

double segment_difference(const Snapshot& frame, const Snapshot& reference) {
  double sum = 0;
  std::size_t count = 0;
  for (std::size_t c = 0; c < frame.connectors.size(); ++c) {
    const std::vector<Vec3>& a = frame.connectors[c];
    const std::vector<Vec3>& b = reference.connectors[c];
    for (std::size_t i = 0; i + 1 < a.size(); ++i) {
      sum += ((a[i] + a[i + 1]) - (b[i] + b[i + 1])).norm() / 2;
      ++count;
    }
  }
  return count ? sum / static_cast<double>(count) : 0;
}

namespace {

/// By how much the share of `a` below some value exceeds that of `b` below a `same` larger one.
double excess(std::span<const double> a, std::span<const double> b, double same) {
  double largest = 0;
  std::size_t below = 0;  // of b
  for (std::size_t i = 0; i < a.size(); ++i) {
    while (below < b.size() && b[below] <= a[i] + same) ++below;
    const double more = static_cast<double>(i + 1) / static_cast<double>(a.size()) -
                        static_cast<double>(below) / static_cast<double>(b.size());
    largest = std::max(largest, more);
  }
  return largest;
}

}  // namespace

void Speeds::add(const std::vector<Vec3>& points, double dt) {
  for (std::size_t i = 0; i < last_.size(); ++i) {
    speeds_.push_back((points[i] - last_[i]).norm() / dt);
  }
  last_ = points;
}

std::vector<double> Speeds::sorted() const {
  std::vector<double> all = speeds_;
  std::ranges::sort(all);
  return all;
}

void EnergyDifference::add(double more) {
  if (!(std::abs(more) <= largest_)) largest_ = std::abs(more);  // keeps what is no number, too
  sum_ += more;
  ++frames_;
}

double EnergyDifference::of_means() const {
  return frames_ > 0 ? std::abs(sum_) / static_cast<double>(frames_) : 0;
}

double distribution_distance(std::span<const double> a, std::span<const double> b, double same) {
  if (a.empty() || b.empty()) return a.empty() == b.empty() ? 0 : 1;
  return std::max(excess(a, b, same), excess(b, a, same));
}

}  // namespace taut::study
