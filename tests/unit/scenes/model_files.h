// Small model files made in memory, to be broken in every way.
#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace taut {

/// A folder of its own for each test, removed with it.
class ModelFiles : public testing::Test {
 protected:
  ModelFiles() {
    const auto* info = testing::UnitTest::GetInstance()->current_test_info();
    folder_ = std::filesystem::temp_directory_path() /
              ("taut_" + std::to_string(getpid()) + "_" + info->name());
    std::filesystem::create_directories(folder_);
  }
  ~ModelFiles() override { std::filesystem::remove_all(folder_); }

  std::filesystem::path write(const std::string& name, const std::string& bytes) const {
    std::ofstream(folder_ / name, std::ios::binary) << bytes;
    return folder_ / name;
  }

  std::filesystem::path folder_;
};

inline void append32(std::string& bytes, std::size_t value) {
  for (int i = 0; i < 4; ++i) bytes += static_cast<char>(value >> 8 * i & 0xff);
}

inline std::string glb(const nlohmann::json& json, const std::string& binary) {
  std::string text = json.dump();
  text.resize((text.size() + 3) / 4 * 4, ' ');
  std::string bytes = "glTF";
  append32(bytes, 2);
  append32(bytes, 12 + 8 + text.size() + 8 + binary.size());
  append32(bytes, text.size());
  bytes += "JSON" + text;
  append32(bytes, binary.size());
  bytes.append("BIN\0", 4);
  return bytes + binary;
}

/// A glTF under construction: one buffer, one accessor per call of `add`.
struct Gltf {
  nlohmann::json json = {{"asset", {{"version", "2.0"}}},
                         {"buffers", {{{"byteLength", 0}}}},
                         {"bufferViews", nlohmann::json::array()},
                         {"accessors", nlohmann::json::array()}};
  std::string binary;

  template <typename T>
  std::size_t add(const std::vector<T>& values, int component, const char* type,
                  std::size_t elements) {
    json["bufferViews"].push_back(
        {{"buffer", 0}, {"byteOffset", binary.size()}, {"byteLength", values.size() * sizeof(T)}});
    json["accessors"].push_back({{"bufferView", json["bufferViews"].size() - 1},
                                 {"componentType", component},
                                 {"count", values.size() / elements},
                                 {"type", type}});
    binary.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T));
    binary.resize((binary.size() + 3) / 4 * 4);
    json["buffers"][0]["byteLength"] = binary.size();
    return json["accessors"].size() - 1;
  }
  std::string bytes() const { return glb(json, binary); }
};

/// A triangle in the xy plane, under a node that moves it by (10, 0, 0) and doubles it.
inline Gltf triangle() {
  Gltf g;
  const auto position = g.add<float>({0, 0, 0, 1, 0, 0, 0, 1, 0}, 5126, "VEC3", 3);
  const auto indices = g.add<std::uint16_t>({0, 1, 2}, 5123, "SCALAR", 1);
  const auto color =
      g.add<std::uint8_t>({255, 0, 0, 255, 0, 51, 0, 255, 0, 0, 255, 255}, 5121, "VEC4", 4);
  g.json["accessors"][color]["normalized"] = true;
  g.json["materials"] = {{{"name", "Brass"},
                          {"pbrMetallicRoughness",
                           {{"baseColorFactor", {0.8, 0.6, 0.3, 1}},
                            {"roughnessFactor", 0.25},
                            {"metallicFactor", 1.0}}}}};
  g.json["meshes"] = {{{"name", "Triangle"},
                       {"primitives",
                        {{{"attributes", {{"POSITION", position}, {"COLOR_0", color}}},
                          {"indices", indices},
                          {"material", 0}}}}}};
  g.json["nodes"] = {
      {{"name", "Node"}, {"mesh", 0}, {"translation", {10, 0, 0}}, {"scale", {2, 2, 2}}}};
  g.json["scenes"] = {{{"nodes", {0}}}};
  return g;
}

/// The triangle skinned by two bones, Root at y = 1 and Tip 0.5 above it; its mesh's node carries
/// the name of a bone, and a child bone without weights ends the chain.
inline Gltf skinned() {
  Gltf g = triangle();
  const auto joints = g.add<std::uint8_t>({0, 1, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0}, 5121, "VEC4", 4);
  const auto weights = g.add<float>({0.75f, 0.25f, 0, 0, 2, 0, 0, 0, 1, 0, 0, 0}, 5126, "VEC4", 4);
  const auto binds = g.add<float>({1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, -1,   0, 1,
                                   1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, -1.5, 0, 1},
                                  5126, "MAT4", 16);
  auto& attributes = g.json["meshes"][0]["primitives"][0]["attributes"];
  attributes["JOINTS_0"] = joints;
  attributes["WEIGHTS_0"] = weights;
  g.json["nodes"] = {{{"name", "Tip"}, {"mesh", 0}, {"skin", 0}, {"translation", {5, 5, 5}}},
                     {{"name", "Root"}, {"translation", {0, 1, 0}}, {"children", {2}}},
                     {{"name", "Tip"}, {"translation", {0, 0.5, 0}}, {"children", {3}}},
                     {{"name", "End"}, {"translation", {0, 0.1, 0}}}};
  g.json["skins"] = {{{"joints", {1, 2}}, {"inverseBindMatrices", binds}}};
  g.json["scenes"] = {{{"nodes", {0, 1}}}};
  return g;
}

/// The skinned triangle, whose root turns and whose tip moves by a spline.
inline Gltf animated() {
  Gltf g = skinned();
  const auto times = g.add<float>({0, 1}, 5126, "SCALAR", 1);
  const auto turns = g.add<float>({0, 0, 0, 1, 0, 0, 1, 0}, 5126, "VEC4", 4);
  const auto places = g.add<float>(std::vector<float>(18, 0.5f), 5126, "VEC3", 3);
  g.json["animations"] = {
      {{"name", "Turn"},
       {"samplers",
        {{{"input", times}, {"output", turns}},
         {{"input", times}, {"output", places}, {"interpolation", "CUBICSPLINE"}}}},
       {"channels",
        {{{"sampler", 0}, {"target", {{"node", 1}, {"path", "rotation"}}}},
         {{"sampler", 1}, {"target", {{"node", 2}, {"path", "translation"}}}}}}}};
  return g;
}

}  // namespace taut
