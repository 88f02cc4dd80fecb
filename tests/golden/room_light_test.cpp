// Light that a room throws back, where it is known: one wall glows, everything else is black.
#include "render/draw/shading/room_light.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "render/draw/stage_parts.h"
#include "render/gl/context.h"

namespace taut::room_light_test {
namespace {

constexpr double kWide = 4, kHigh = 3, kDeep = 5;  // m
constexpr float kAlbedo = 0.5f;
constexpr double kGlow = 0.70 * kAlbedo;  // of paper, as a share of the key light
constexpr double kPixel = 2.0 / 32;       // of the pictures, m at 1 m

/// A wall that faces the room: its middle, and half its sides, the first times the second inwards.
scenes::Mesh wall(std::size_t material, const Vec3& middle, const Vec3& right, const Vec3& up) {
  scenes::Mesh mesh;
  mesh.material = material;
  const Vec3 normal = right.cross(up).normalized();
  for (const auto& [x, y] : {std::pair(-1, -1), {1, -1}, {1, 1}, {-1, 1}}) {
    const Vec3 p = middle + x * right + y * up;
    scenes::Vertex& v = mesh.vertices.emplace_back();
    for (int k = 0; k < 3; ++k) {
      v.position[std::size_t(k)] = float(p[k]);
      v.normal[std::size_t(k)] = float(normal[k]);
    }
  }
  mesh.indices = {0, 1, 2, 0, 2, 3};
  return mesh;
}

scenes::Model walls() {
  const Vec3 x = Vec3::UnitX() * (kWide / 2), y = Vec3::UnitY() * (kHigh / 2),
             z = Vec3::UnitZ() * (kDeep / 2);
  scenes::Model model;
  // Metal without colour mirrors and scatters nothing.
  model.materials = {{"paper", {kAlbedo, kAlbedo, kAlbedo}, 1, 0}, {"soot", {0, 0, 0}, 1, 1}};
  model.meshes = {wall(0, y - z, x, y), wall(1, y + z, -x, y),        wall(1, y - x, -z, y),
                  wall(1, y + x, z, y), wall(1, Vec3::Zero(), x, -z), wall(1, 2 * y, x, z)};
  return model;
}

/// Behind the paper: it reaches no wall from inside.
scenes::Light light() {
  return {Vec3::UnitZ(), Vec3::Ones(), Vec3::Zero(), Vec3::Zero()};
}

/// The share of a hemisphere, weighted by its cosine, that a rectangle takes: sides a and b from
/// the foot of the point's perpendicular, c away.
double corner(double a, double b, double c) {
  const double ac = std::hypot(a, c), bc = std::hypot(b, c);
  return (a / ac * std::atan(b / ac) + b / bc * std::atan(a / bc)) / (2 * std::numbers::pi);
}

class RoomLightTest : public testing::Test {
 protected:
  draw::RoomLight lit(const scenes::Model& model) const {
    std::vector<draw::Drawable> things = draw::drawables(context_.gl(), model);
    std::vector<const scenes::Mesh*> meshes;
    for (const scenes::Mesh& mesh : model.meshes) meshes.push_back(&mesh);
    const draw::SceneryShadow none(context_.gl(), light(), things);
    return {context_.gl(), light(), things, meshes, none, Vec3(0, 1, 0)};
  }

  /// The red light on a vertex.
  static double on(const draw::RoomLight& light, const Vec3& place, const Vec3& normal) {
    scenes::Mesh mesh;
    scenes::Vertex& v = mesh.vertices.emplace_back();
    for (int k = 0; k < 3; ++k) {
      v.position[std::size_t(k)] = float(place[k]);
      v.normal[std::size_t(k)] = float(normal[k]);
    }
    return double(light.on(mesh).front().x());
  }

  gl::Context context_{gl::Backend::automatic};
};

TEST_F(RoomLightTest, AWallThatGlowsLightsWhatFacesItByItsShareOfTheView) {
  const draw::RoomLight room = lit(walls());
  ASSERT_TRUE(room.encloses());
  // Points of the grid, where nothing is interpolated: 0.25 m from the floor and the wall opposite.
  for (const double share : {1.0 / 3, 2.0 / 3, 1.0}) {
    const Vec3 place(0.25 - kWide / 2, 0.25, std::lerp(0.25, kDeep - 0.25, share) - kDeep / 2);
    const double away = place.z() + kDeep / 2;
    double seen = 0;
    for (const double a : {0.25, kWide - 0.25})
      for (const double b : {0.25, kHigh - 0.25}) seen += corner(a, b, away);
    // A pixel is of the wall or not: each edge is off by half of one at most.
    const double cut = kPixel * away * (1 / kWide + 1 / kHigh);
    EXPECT_NEAR(on(room, place, -Vec3::UnitZ()), kGlow * seen, kGlow * cut * seen) << away;
  }
}

TEST_F(RoomLightTest, WhatFacesAwayIsDark) {
  const draw::RoomLight room = lit(walls());
  const Vec3 place(0, 1, kDeep / 2 - 0.25);
  // What a surface mirrors is fitted to a hundredth of the light.
  EXPECT_LT(std::abs(on(room, place, Vec3::UnitZ())), 0.01 * on(room, place, -Vec3::UnitZ()));
}

TEST_F(RoomLightTest, AFloorAloneIsNoRoom) {
  scenes::Model model = walls();
  model.meshes = {model.meshes[4]};
  EXPECT_FALSE(lit(model).encloses());
  EXPECT_FALSE(lit({}).encloses());
}

}  // namespace
}  // namespace taut::room_light_test
