// The pictures of a comparison's clip, in their order.
#include <algorithm>
#include <map>

#include "render/film/comparison.h"

namespace taut::film {
namespace {

constexpr double kStop = 1.1;  // s
constexpr double kCard = 5;    // s
constexpr double kFade = 0.4;  // s, in which the card comes

int frames_of(double seconds, int fps) {
  return std::max(int(std::lround(seconds * fps)), 1);
}

}  // namespace

std::size_t most_moments(std::size_t frames, int fps, int slower, std::size_t methods) {
  const std::size_t stops = methods * std::size_t(frames_of(kStop, fps));
  return frames * std::size_t(slower + 1) + stops + std::size_t(frames_of(kCard, fps));
}

std::vector<Moment> moments_of(const Comparison& comparison) {
  std::vector<Moment> moments;
  const int slower = comparison.slower, stop = frames_of(kStop, comparison.fps);
  if (slower > 1) {
    std::map<std::size_t, std::vector<std::size_t>> stops;  // by instant
    const std::size_t last = comparison.instants() - 1;
    for (std::size_t i = 0; i < comparison.methods.size(); ++i) {
      const Verdict& verdict = comparison.methods[i].verdict;
      if (verdict.grade == Verdict::Grade::none) continue;
      const bool right = verdict.grade == Verdict::Grade::kept;
      stops[right ? last : std::min(verdict.worst * std::size_t(slower), last)].push_back(i);
    }
    for (std::size_t k = 0; k <= last; ++k) {
      moments.push_back({.instant = k, .slower = slower});
      const auto here = stops.find(k);
      if (here == stops.end()) continue;
      // Those that are right share a stop; the others have one each.
      std::vector<std::size_t> right;
      for (const std::size_t i : here->second) {
        if (comparison.methods[i].verdict.grade == Verdict::Grade::kept)
          right.push_back(i);
        else
          moments.insert(moments.end(), std::size_t(stop),
                         {.instant = k, .slower = slower, .stopped = {i}});
      }
      if (!right.empty())
        moments.insert(moments.end(), std::size_t(stop),
                       {.instant = k, .slower = slower, .stopped = right});
    }
  }
  for (std::size_t k = 0; k < comparison.times.size(); ++k)
    moments.push_back({.instant = k * std::size_t(slower)});
  const int card = frames_of(kCard, comparison.fps);
  for (int k = 1; k <= card; ++k)
    moments.push_back({.instant = comparison.instants() - 1,
                       .card = std::min(double(k) / (kFade * comparison.fps), 1.0)});
  return moments;
}

}  // namespace taut::film
