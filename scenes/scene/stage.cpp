#include "scenes/scene/stage.h"

#include <algorithm>
#include <cmath>
#include <span>

namespace taut::scenes {

namespace {

constexpr double kNearest = 0.05;  // m, of the focus

/// The rate of change of a key's `member` through its neighbours, zero at the first and the last,
/// so that the camera starts and stops gently.
template <typename Member>
auto rate(std::span<const CameraKey> keys, std::size_t i, Member member) {
  const auto at = [&](std::size_t k) { return std::invoke(member, keys[k]); };
  using Value = std::decay_t<decltype(at(0))>;
  if (i == 0 || i + 1 == keys.size()) return Value(at(i) * 0.0);
  return Value((at(i + 1) - at(i - 1)) / (keys[i + 1].time - keys[i - 1].time));
}

/// The cubic through keys i and i + 1 with those rates, at the share `u` of the way.
template <typename Member>
auto between(std::span<const CameraKey> keys, std::size_t i, double u, Member member) {
  const double dt = keys[i + 1].time - keys[i].time, v = 1 - u;
  const auto a = std::invoke(member, keys[i]), b = std::invoke(member, keys[i + 1]);
  using Value = std::decay_t<decltype(a)>;
  return Value(v * v * (1 + 2 * u) * a + u * u * (3 - 2 * u) * b +
               u * v * dt * (v * rate(keys, i, member) - u * rate(keys, i + 1, member)));
}

double focus_of(const CameraKey& key) {
  return key.focus.value_or((key.target - key.position).norm());
}

/// The keys about i and i + 1 that all have an orbit, and the place of i among them; none where
/// one of these two has none.
std::pair<std::span<const CameraKey>, std::size_t> orbit_around(std::span<const CameraKey> keys,
                                                                std::size_t i) {
  if (!keys[i].orbit || !keys[i + 1].orbit) return {};
  std::size_t first = i, end = i + 2;
  while (first > 0 && keys[first - 1].orbit) --first;
  while (end < keys.size() && keys[end].orbit) ++end;
  return {keys.subspan(first, end - first), i - first};
}

}  // namespace

Vec3 on_orbit(const Vec3& orbit) {
  const double level = orbit.z() * std::cos(orbit.y());
  return {level * std::sin(orbit.x()), orbit.z() * std::sin(orbit.y()),
          level * std::cos(orbit.x())};
}

CameraView camera_at(const std::vector<CameraKey>& keys, double time) {
  const auto after = std::ranges::upper_bound(keys, time, {}, &CameraKey::time);
  const auto next = static_cast<std::size_t>(after - keys.begin());
  if (next == 0 || next == keys.size()) {
    const CameraKey& key = next == 0 ? keys.front() : keys.back();
    return {key.position, key.target, key.field_of_view, key.relative_aperture, focus_of(key)};
  }
  const std::size_t i = next - 1;
  const double u = (time - keys[i].time) / (keys[next].time - keys[i].time);
  const std::span<const CameraKey> all = keys;
  CameraView view{between(all, i, u, &CameraKey::position), between(all, i, u, &CameraKey::target),
                  between(all, i, u, &CameraKey::field_of_view),
                  std::max(between(all, i, u, &CameraKey::relative_aperture), 0.0),
                  std::max(between(all, i, u, focus_of), kNearest)};
  view.moves = keys[i].position != keys[next].position || keys[i].target != keys[next].target ||
               keys[i].field_of_view != keys[next].field_of_view ||
               keys[i].orbit != keys[next].orbit;
  if (const auto [round, at] = orbit_around(all, i); !round.empty())
    view.position =
        view.target +
        on_orbit(between(round, at, u, [](const CameraKey& key) { return *key.orbit; }));
  return view;
}

std::vector<std::string> left_out(const Stage& stage) {
  std::vector<std::string> lines;
  for (const auto* models : {&stage.scenery, &stage.body_models, &stage.characters}) {
    for (const auto& model : *models) {
      if (!model) continue;
      for (const std::string& line : model->left_out) {
        if (std::ranges::find(lines, line) == lines.end()) lines.push_back(line);
      }
    }
  }
  return lines;
}

}  // namespace taut::scenes
