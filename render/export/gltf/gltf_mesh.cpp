#include "render/export/gltf/gltf_mesh.h"

#include <algorithm>
#include <cmath>

namespace taut::exporting {
namespace {

using Json = GltfFile::Json;
using Use = GltfFile::Use;

constexpr std::uint16_t kWhole = 65535;

/// A vertex's bones, each once, and their weights, which add up to kWhole.
struct Weights {
  std::array<std::uint16_t, 4> joints{};
  std::array<std::uint16_t, 4> shares{};

  Weights(const scenes::Vertex& vertex, std::size_t fixed_joint) {
    double sum = 0;
    for (const float weight : vertex.weights) sum += weight;
    if (sum == 0) {
      joints[0] = std::uint16_t(fixed_joint);
      shares[0] = kWhole;
      return;
    }
    std::size_t used = 0;
    std::array<double, 4> exact{};
    for (std::size_t k = 0; k < 4; ++k) {
      if (vertex.weights[k] == 0) continue;
      const auto end = joints.begin() + std::ptrdiff_t(used);
      const auto same = std::find(joints.begin(), end, vertex.bones[k]);
      const auto slot = std::size_t(same - joints.begin());
      joints[slot] = vertex.bones[k];
      exact[slot] += kWhole * (vertex.weights[k] / sum);
      used = std::max(used, slot + 1);
    }
    // The largest takes what is left over by rounding.
    int left = kWhole;
    for (std::size_t k = 0; k < 4; ++k) {
      shares[k] = std::uint16_t(std::lround(exact[k]));
      left -= shares[k];
    }
    auto& largest = *std::ranges::max_element(shares);
    largest = std::uint16_t(largest + left);
  }
};

}  // namespace

std::size_t GltfMeshes::of_model(const scenes::Model& model) {
  const auto [place, is_new] = models_.try_emplace(&model, 0);
  if (!is_new) return place->second;
  Json primitives = Json::array();
  for (const scenes::Mesh& mesh : model.meshes)
    if (!mesh.indices.empty())
      primitives.push_back(primitive(mesh, model.materials[mesh.material], !model.bones.empty(),
                                     model.bones.size()));
  place->second =
      file_.add("meshes", {{"name", model.name}, {"primitives", std::move(primitives)}});
  return place->second;
}

bool GltfMeshes::has_fixed_vertices(const scenes::Model& model) {
  for (const scenes::Mesh& mesh : model.meshes)
    for (const scenes::Vertex& v : mesh.vertices)
      if (v.weights[0] + v.weights[1] + v.weights[2] + v.weights[3] == 0) return true;
  return false;
}

std::size_t GltfMeshes::of_mesh(const std::string& name, const scenes::Mesh& mesh,
                                const scenes::Material& with, bool skinned) {
  return file_.add("meshes", {{"name", name}, {"primitives", {primitive(mesh, with, skinned, 0)}}});
}

Json GltfMeshes::primitive(const scenes::Mesh& mesh, const scenes::Material& with, bool skinned,
                           std::size_t fixed_joint) {
  // Colours of eight bits are shares of the brightest, which the material has.
  std::array<float, 3> tint{};
  for (const scenes::Vertex& v : mesh.vertices)
    for (std::size_t k = 0; k < 3; ++k) tint[k] = std::max(tint[k], v.color[k]);
  std::vector<float> positions, normals;
  std::vector<std::uint8_t> colors;
  std::vector<std::uint16_t> joints, weights;
  bool tinted = false;
  for (const scenes::Vertex& v : mesh.vertices) {
    positions.insert(positions.end(), v.position.begin(), v.position.end());
    const Vec3 normal(v.normal[0], v.normal[1], v.normal[2]);
    const Vec3 unit = normal.norm() > 0 ? Vec3(normal.normalized()) : Vec3::UnitY();
    for (const double number : unit) normals.push_back(float(number));
    for (std::size_t k = 0; k < 3; ++k) {
      const float share = tint[k] > 0 ? std::max(v.color[k], 0.0f) / tint[k] : 1;
      colors.push_back(std::uint8_t(std::lround(share * 255)));
      tinted |= colors.back() != 255;
    }
    colors.push_back(255);
    if (!skinned) continue;
    const Weights own(v, fixed_joint);
    joints.insert(joints.end(), own.joints.begin(), own.joints.end());
    weights.insert(weights.end(), own.shares.begin(), own.shares.end());
  }
  const auto add = [&](const auto& numbers, GltfFile::Numbers about) {
    return file_.add_numbers(std::span(numbers), about);
  };
  Json attributes = {
      {"POSITION", add(positions, {GltfFile::f32, "VEC3", Use::vertices, false, true})},
      {"NORMAL", add(normals, {GltfFile::f32, "VEC3", Use::vertices})}};
  if (tinted) attributes["COLOR_0"] = add(colors, {GltfFile::u8, "VEC4", Use::vertices, true});
  if (skinned) {
    if (std::ranges::all_of(joints, [](std::uint16_t joint) { return joint < 256; })) {
      const std::vector<std::uint8_t> small(joints.begin(), joints.end());
      attributes["JOINTS_0"] = add(small, {GltfFile::u8, "VEC4", Use::vertices});
    } else {
      attributes["JOINTS_0"] = add(joints, {GltfFile::u16, "VEC4", Use::vertices});
    }
    attributes["WEIGHTS_0"] = add(weights, {GltfFile::u16, "VEC4", Use::vertices, true});
  }
  std::size_t indices = 0;
  if (mesh.vertices.size() <= 65535) {
    const std::vector<std::uint16_t> small(mesh.indices.begin(), mesh.indices.end());
    indices = add(small, {GltfFile::u16, "SCALAR", Use::indices});
  } else {
    indices = add(mesh.indices, {GltfFile::u32, "SCALAR", Use::indices});
  }
  return {{"attributes", std::move(attributes)},
          {"indices", indices},
          {"material", material(with, tint)}};
}

std::size_t GltfMeshes::material(const scenes::Material& with, const std::array<float, 3>& tint) {
  Json color = Json::array();
  for (std::size_t k = 0; k < 3; ++k)
    color.push_back(std::clamp(with.base_color[k] * tint[k], 0.0f, 1.0f));
  color.push_back(1);
  const Json said = {{"name", with.name},
                     {"pbrMetallicRoughness",
                      {{"baseColorFactor", std::move(color)},
                       {"metallicFactor", std::clamp(with.metallic, 0.0f, 1.0f)},
                       {"roughnessFactor", std::clamp(with.roughness, 0.0f, 1.0f)}}}};
  const auto [place, is_new] = materials_.try_emplace(said.dump(), 0);
  if (is_new) place->second = file_.add("materials", said);
  return place->second;
}

scenes::Mesh plain_mesh(std::span<const mesh::MovingVertex> vertices,
                        std::span<const std::uint32_t> indices, const Eigen::Vector3f& color) {
  scenes::Mesh mesh;
  mesh.indices.assign(indices.begin(), indices.end());
  for (const mesh::MovingVertex& v : vertices)
    mesh.vertices.push_back({{v.position.x(), v.position.y(), v.position.z()},
                             {v.normal.x(), v.normal.y(), v.normal.z()},
                             {color.x(), color.y(), color.z()}});
  return mesh;
}

}  // namespace taut::exporting
