#include "render/export/gltf/gltf_motion.h"

#include <algorithm>
#include <cmath>

namespace taut::exporting {
namespace {

/// True where no component, of so many an item, changes by more than `most`.
template <typename Number>
bool stands(const std::vector<Number>& numbers, std::size_t size, double most) {
  for (std::size_t k = 0; k < size; ++k) {
    Number least = numbers[k], largest = numbers[k];
    for (std::size_t i = k; i < numbers.size(); i += size) {
      least = std::min(least, numbers[i]);
      largest = std::max(largest, numbers[i]);
    }
    if (double(largest) - double(least) > most) return false;
  }
  return true;
}

constexpr double kOne = 32767;  // of 16 bits

}  // namespace

void GltfMotion::translate(std::size_t node, const Vec3& to) {
  for (const double number : to) translations_[node].push_back(float(number));
}

void GltfMotion::turn(std::size_t node, const Quat& to) {
  std::vector<std::int16_t>& track = rotations_[node];
  Eigen::Vector4d q = to.normalized().coeffs();
  if (!track.empty()) {
    double dot = 0;
    for (std::size_t k = 0; k < 4; ++k) dot += double(track[track.size() - 4 + k]) * q[int(k)];
    if (dot < 0) q *= -1;
  }
  for (const double number : q) track.push_back(std::int16_t(std::lround(number * kOne)));
}

void GltfMotion::spline_translation(std::size_t node, const std::vector<float>& numbers) {
  spline(node, "translation", 3, numbers);
}

void GltfMotion::spline_rotation(std::size_t node, const std::vector<float>& numbers) {
  spline(node, "rotation", 4, numbers);
}

void GltfMotion::spline(std::size_t node, const char* path, std::size_t size,
                        const std::vector<float>& numbers) {
  if (stands(numbers, 3 * size, 0)) {
    const auto value = numbers.begin() + std::ptrdiff_t(size);
    file_.node(node)[path] = std::vector<float>(value, value + std::ptrdiff_t(size));
    return;
  }
  channel(node, path, "CUBICSPLINE",
          file_.add_numbers(std::span(numbers), {GltfFile::f32, size == 3 ? "VEC3" : "VEC4"}));
}

void GltfMotion::channel(std::size_t node, const char* path, const char* interpolation,
                         std::size_t output) {
  channels_.push_back(
      {{"sampler", samplers_.size()}, {"target", {{"node", node}, {"path", path}}}});
  samplers_.push_back({{"input", nullptr}, {"interpolation", interpolation}, {"output", output}});
}

void GltfMotion::finish(const std::string& name, const std::vector<float>& times) {
  for (const auto& [node, numbers] : translations_) {
    constexpr double kStill = 1e-7;  // m
    if (stands(numbers, 3, kStill)) {
      file_.place(node, {Vec3(numbers[0], numbers[1], numbers[2]), Quat::Identity()});
    } else {
      channel(node, "translation", "LINEAR",
              file_.add_numbers(std::span(numbers), {GltfFile::f32, "VEC3"}));
    }
  }
  for (const auto& [node, numbers] : rotations_) {
    if (stands(numbers, 4, 2)) {
      file_.place(node, {Vec3::Zero(), Quat(numbers[3], numbers[0], numbers[1], numbers[2])});
    } else {
      channel(node, "rotation", "LINEAR",
              file_.add_numbers(std::span(numbers),
                                {GltfFile::i16, "VEC4", GltfFile::Use::animation, true}));
    }
  }
  if (channels_.empty()) return;
  const std::size_t input = file_.add_numbers(
      std::span(times), {GltfFile::f32, "SCALAR", GltfFile::Use::animation, false, true});
  for (GltfFile::Json& sampler : samplers_) sampler["input"] = input;
  file_.add(
      "animations",
      {{"name", name}, {"channels", std::move(channels_)}, {"samplers", std::move(samplers_)}});
}

}  // namespace taut::exporting
