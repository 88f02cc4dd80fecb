#include "sim/evaluation/accuracy.h"

#include <cmath>
#include <limits>
#include <stdexcept>

namespace taut::study {
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

}  // namespace taut::study
