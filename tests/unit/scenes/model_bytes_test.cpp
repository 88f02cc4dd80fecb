// A model between two processes: to the bit, or not at all.
#include "scenes/model/model_bytes.h"

#include <gtest/gtest.h>

#include <limits>
#include <random>

#include "scenes/model/import.h"
#include "scenes/model/load_model.h"
#include "tests/support/folder.h"
#include "tests/unit/scenes/model_files.h"

namespace taut::model_bytes_test {
namespace {

scenes::Model small() {
  scenes::NamedFiles none;
  return *scenes::import_model("small.glb", animated().bytes(), none);
}

TEST(ModelBytes, ComeBackToTheBit) {
  for (const char* name : {"martial_artist.glb", "dojo.glb", "peg.glb"}) {
    const std::filesystem::path file = TAUT_SOURCE_DIR "/assets/" + std::string(name);
    const std::string bytes = scenes::to_bytes(scenes::load_model_here(file));
    const auto model = scenes::model_of_bytes(bytes);
    ASSERT_TRUE(model) << name;
    EXPECT_EQ(scenes::to_bytes(*model), bytes) << name;
    EXPECT_EQ(scenes::to_bytes(scenes::load_model(file)), bytes) << name;
  }
}

TEST(ModelBytes, EveryOtherLengthIsRefused) {
  const std::string bytes = scenes::to_bytes(small());
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    EXPECT_FALSE(scenes::model_of_bytes(bytes.substr(0, size))) << size;
  }
  EXPECT_FALSE(scenes::model_of_bytes(bytes + '\0'));
}

TEST(ModelBytes, WhatPointsAtNothingIsRefused) {
  const auto refused = [](const auto& spoil) {
    scenes::Model model = small();
    spoil(model);
    return !scenes::model_of_bytes(scenes::to_bytes(model));
  };
  EXPECT_FALSE(refused([](scenes::Model&) {}));
  EXPECT_TRUE(refused([](scenes::Model& m) { m.meshes[0].material = m.materials.size(); }));
  EXPECT_TRUE(refused([](scenes::Model& m) {
    m.meshes[0].indices[0] = static_cast<std::uint32_t>(m.meshes[0].vertices.size());
  }));
  EXPECT_TRUE(refused([](scenes::Model& m) {
    m.meshes[0].vertices[0].bones[0] = static_cast<std::uint16_t>(m.bones.size());
  }));
  EXPECT_TRUE(refused([](scenes::Model& m) { m.bones[0].parent = 0; }));
  EXPECT_TRUE(refused([](scenes::Model& m) { m.bones[0].parent = -2; }));
  EXPECT_TRUE(refused([](scenes::Model& m) { m.bones.resize(257); }));
  EXPECT_TRUE(refused([](scenes::Model& m) { m.animations[0].tracks[0].bone = 4; }));
  EXPECT_TRUE(refused([](scenes::Model& m) { m.animations[0].tracks[0].values.pop_back(); }));
  EXPECT_TRUE(refused([](scenes::Model& m) { m.animations[0].tracks[0].times[0] = 2; }));
  EXPECT_TRUE(refused([](scenes::Model& m) { m.animations[0].tracks[1].times.clear(); }));
  const float infinite = std::numeric_limits<float>::infinity();
  EXPECT_TRUE(refused([=](scenes::Model& m) { m.meshes[0].vertices[1].position[2] = infinite; }));
  EXPECT_TRUE(refused([=](scenes::Model& m) { m.materials[0].roughness = infinite; }));
  EXPECT_TRUE(refused([=](scenes::Model& m) { m.bones[0].rest.position.x() = infinite; }));
}

TEST(ModelBytes, DamagedOnesAreRefusedOrSound) {
  std::mt19937 random(1);
  const std::string whole = scenes::to_bytes(small());
  for (int round = 0; round < 20'000; ++round) {
    std::string bytes = whole;
    for (unsigned damage = 0; damage < 1 + random() % 4; ++damage)
      bytes[random() % bytes.size()] = static_cast<char>(random());
    const auto model = scenes::model_of_bytes(bytes);
    EXPECT_TRUE(!model || scenes::to_bytes(*model) == bytes);
  }
}

}  // namespace
}  // namespace taut::model_bytes_test
