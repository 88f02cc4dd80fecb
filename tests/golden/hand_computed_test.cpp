// Pictures whose pixels can be computed by hand: a sphere under the key light, in even ambient
// light, and the background.
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <numbers>

#include "render/draw/stage_renderer.h"

namespace taut::hand_computed_test {
namespace {

constexpr int kSize = 257;  // odd: a pixel's centre is on the axis
constexpr double kRadius = 0.5, kDistance = 4, kFieldOfView = 0.3;

std::shared_ptr<const scenes::Model> sphere(const scenes::Material& material) {
  auto model = std::make_shared<scenes::Model>();
  model->materials = {material};
  scenes::Mesh mesh;
  constexpr std::uint32_t kRings = 200, kSides = 400;
  for (std::uint32_t i = 0; i <= kRings; ++i)
    for (std::uint32_t j = 0; j < kSides; ++j) {
      const double polar = std::numbers::pi * i / kRings, turn = -2 * std::numbers::pi * j / kSides;
      const Vec3 n(std::sin(polar) * std::cos(turn), -std::cos(polar),
                   std::sin(polar) * std::sin(turn));
      scenes::Vertex v;
      for (int k = 0; k < 3; ++k) {
        v.normal[std::size_t(k)] = float(n[k]);
        v.position[std::size_t(k)] = float(kRadius * n[k]);
      }
      mesh.vertices.push_back(v);
    }
  for (std::uint32_t i = 0; i < kRings; ++i)
    for (std::uint32_t j = 0; j < kSides; ++j) {
      const std::uint32_t a = i * kSides + j, b = i * kSides + (j + 1) % kSides;
      for (const std::uint32_t v : {a, b, a + kSides, a + kSides, b, b + kSides})
        mesh.indices.push_back(v);
    }
  model->meshes = {mesh};
  return model;
}

/// Light to 8 bits: exposure 0.44, the tone curve, sRGB (IEC 61966-2-1).
double display(double radiance) {
  const double x = 0.44 * radiance;
  const double y = std::min(x * (2.51 * x + 0.06) / (x * (2.43 * x + 0.59) + 0.14), 1.0);
  return 255 * (y <= 0.0031308 ? 12.92 * y : 1.055 * std::pow(y, 1 / 2.4) - 0.055);
}

picture::Picture render(const scenes::Stage& stage, const Vec3& camera) {
  World world;
  Body body;
  world.bodies.push_back(body);
  const gl::Context context(gl::Backend::automatic);
  gl::Canvas canvas(context, kSize, kSize, 4);
  draw::StageRenderer renderer(context, stage, world);
  const draw::View view{{0, 0, kSize, kSize}, {camera, Vec3::Zero(), kFieldOfView}};
  renderer.begin(canvas, {&view, 1});
  renderer.draw(canvas, view.viewport, {snapshot(world), {}, view.camera});
  return canvas.finish();
}

/// The sphere's point and normal behind a pixel's centre, seen from (0, 0, kDistance).
Vec3 normal_at(int column, int row) {
  const double half = std::tan(kFieldOfView / 2);
  const Vec3 ray = Vec3((column + 0.5 - kSize / 2.0) * 2 / kSize * half,
                        -(row + 0.5 - kSize / 2.0) * 2 / kSize * half, -1)
                       .normalized();
  const Vec3 eye(0, 0, kDistance);
  const double b = eye.dot(ray), c = eye.squaredNorm() - kRadius * kRadius;
  return (eye + (-b - std::sqrt(b * b - c)) * ray) / kRadius;
}

scenes::Stage plain_stage(double albedo) {
  scenes::Stage stage;
  stage.light = {Vec3(0, 0, -1), Vec3::Zero(), Vec3::Zero(), Vec3::Zero()};
  const auto a = float(albedo);
  stage.body_models = {sphere({.name = "matt", .base_color = {a, a, a}, .roughness = 1})};
  return stage;
}

TEST(HandComputed, SphereUnderTheKeyLight) {
  constexpr double kAlbedo = 0.5, kKey = 1.2;
  scenes::Stage stage = plain_stage(kAlbedo);
  const Vec3 light = Vec3(0.4, 0.3, 1).normalized();
  stage.light.direction = -light;
  stage.light.color = Vec3::Constant(kKey);
  const picture::Picture picture = render(stage, Vec3(0, 0, kDistance));
  for (const auto& [column, row] :
       {std::pair(128, 128), {150, 128}, {128, 90}, {100, 150}, {165, 110}}) {
    // GGX at roughness 1, Schlick's visibility with k = 1/2, Fresnel from 0.04.
    const Vec3 n = normal_at(column, row), p = kRadius * n;
    const Vec3 v = (Vec3(0, 0, kDistance) - p).normalized(), h = (v + light).normalized();
    const double nl = n.dot(light), nv = n.dot(v);
    const double visibility = 0.25 / ((0.5 * nl + 0.5) * (0.5 * nv + 0.5));
    const double fresnel = 0.04 + 0.96 * std::pow(1 - v.dot(h), 5);
    const double radiance = kKey * nl * (kAlbedo + visibility * fresnel);
    EXPECT_NEAR(*picture.at(column, row), display(radiance), 1.6)
        << "column " << column << ", row " << row;
  }
}

TEST(HandComputed, SphereInEvenLight) {
  constexpr double kAlbedo = 0.5, kSky = 0.7;
  scenes::Stage stage = plain_stage(kAlbedo);
  stage.light.sky = stage.light.ground = Vec3::Constant(kSky);
  const picture::Picture picture = render(stage, Vec3(0, 0, kDistance));
  // Lambert's part is exact; the specular part of the fit at normal incidence and roughness 1:
  // r = (0, 0.015, 0.468, -0.018), grazing 0.015, so 0.04 * 0.4524 - 0.0024.
  const double radiance = kSky * (kAlbedo + 0.04 * 0.4524 - 0.0024);
  EXPECT_NEAR(*picture.at(128, 128), display(radiance), 1.6);
}

TEST(HandComputed, Background) {
  scenes::Stage stage = plain_stage(0.5);
  stage.background = Vec3(0.1, 1, 0);
  const picture::Picture picture = render(stage, Vec3(0, 0, kDistance));
  EXPECT_NEAR(picture.at(2, 2)[0], 255 * (1.055 * std::pow(0.1, 1 / 2.4) - 0.055), 1.1);
  EXPECT_EQ(picture.at(2, 2)[1], 255) << "as it was asked for";
  EXPECT_EQ(picture.at(2, 2)[2], 0);
}

TEST(HandComputed, HalfTheLightIsSeen) {
  scenes::Stage stage = plain_stage(0.5);
  stage.light.color = Vec3::Constant(1.2);
  const Vec3 camera(0, 0, kDistance);
  const picture::Picture full = render(stage, camera);
  stage.light.color *= 0.5;
  EXPECT_GT(int(*full.at(128, 128)) - int(*render(stage, camera).at(128, 128)), 30);
}

/// A square in a horizontal plane, seen from above.
std::shared_ptr<const scenes::Model> square(double half_side, const scenes::Material& material) {
  auto model = std::make_shared<scenes::Model>();
  model->materials = {material};
  scenes::Mesh mesh;
  for (const auto& [x, z] : {std::pair(-1, -1), {-1, 1}, {1, 1}, {1, -1}}) {
    scenes::Vertex v;
    v.position = {float(half_side * x), 0, float(half_side * z)};
    v.normal = {0, 1, 0};
    mesh.vertices.push_back(v);
  }
  mesh.indices = {0, 1, 2, 0, 2, 3};
  model->meshes = {mesh};
  return model;
}

TEST(HandComputed, APictureMultipliesTheColour) {
  // Two pixels, red and half of sRGB's grey, nearest, on a square seen from above.
  constexpr double kSky = 0.7;
  scenes::Stage stage;
  stage.light.sky = stage.light.ground = Vec3::Constant(kSky);
  stage.light.color = Vec3::Zero();
  auto made = std::make_shared<scenes::Model>(*square(
      0.5, {.name = "matt", .base_color = {0.8f, 0.5f, 0.5f}, .roughness = 1, .texture = 0}));
  made->textures = {{.width = 2,
                     .height = 1,
                     .magnify = 9728,
                     .minify = 9728,
                     .pixels = {255, 0, 0, 255, 188, 188, 188, 255}}};
  for (scenes::Vertex& v : made->meshes[0].vertices)
    v.uv = {v.position[0] + 0.5f, v.position[2] + 0.5f};
  stage.body_models = {made};
  const picture::Picture picture = render(stage, Vec3(0, kDistance, 1e-3));
  const double gloss = 0.04 * 0.4524 - 0.0024, grey = std::pow((188 / 255.0 + 0.055) / 1.055, 2.4);
  const std::uint8_t* red = picture.at(100, 128);
  EXPECT_NEAR(red[0], display(kSky * (0.8 + gloss)), 1.6);
  EXPECT_NEAR(red[1], display(kSky * gloss), 2.5);
  EXPECT_NEAR(red[2], display(kSky * gloss), 2.5);
  const std::uint8_t* other = picture.at(156, 128);
  EXPECT_NEAR(other[0], display(kSky * (0.8 * grey + gloss)), 1.6);
  EXPECT_NEAR(other[1], display(kSky * (0.5 * grey + gloss)), 1.6);
}

TEST(HandComputed, AShadowEndsWhereTheLightGoesPast) {
  // A plate of 0.6 m, 0.5 m above the floor, in light that falls half as far sideways as down:
  // its shadow reaches from x = -0.05 to 0.55 m.
  constexpr double kHeight = 0.5, kHalf = 0.3, kSlope = 0.5;
  scenes::Stage stage;
  const scenes::Material matt{.name = "matt", .base_color = {0.5f, 0.5f, 0.5f}, .roughness = 1};
  stage.scenery = {square(3, matt)};
  stage.body_models = {square(kHalf, matt)};
  stage.light = {Vec3(kSlope, -1, 0), Vec3::Constant(1.2), Vec3::Zero(), Vec3::Zero()};
  World world;
  Body plate;
  plate.position = Vec3(0, kHeight, 0);
  world.bodies.push_back(plate);

  const gl::Context context(gl::Backend::automatic);
  constexpr int kWide = 401;
  gl::Canvas canvas(context, kWide, kWide, 4);
  draw::StageRenderer renderer(context, stage, world);
  const scenes::CameraView camera{Vec3(0.25, 3, 4), Vec3(0.25, 0, 0.25), 0.35};
  const picture::Rect whole{0, 0, kWide, kWide};
  const draw::View view{whole, camera};
  renderer.begin(canvas, {&view, 1});
  renderer.draw(canvas, whole, {snapshot(world), {}, camera});
  const picture::Picture picture = canvas.finish();

  // The camera looks along x = 0.25, so a line of the floor across it is a row of the picture.
  const double distance = (camera.target - camera.position).norm();
  const double pixel = 2 * distance * std::tan(camera.field_of_view / 2) / kWide;  // m
  const auto value = [&](int column) { return int(*picture.at(column, kWide / 2)); };
  const auto x_of = [&](double column) { return 0.25 + (column - kWide / 2) * pixel; };
  const int lit = value(5), dark = value(kWide / 2);
  EXPECT_LE(dark, 1);
  EXPECT_GT(lit, 60);
  std::vector<double> edges;  // where the row crosses half of the light, m
  for (int column = 6; column < kWide; ++column) {
    const int a = value(column - 1), b = value(column);
    if ((2 * a > lit) != (2 * b > lit))
      edges.push_back(x_of(column - 1 + (0.5 * lit - a) / (b - a)));
  }
  ASSERT_EQ(edges.size(), 2u);
  // Half a pixel, and two texels of the shadow map, which covers a little more than the plate.
  const double tolerance = pixel / 2 + 2 * 2.0 / draw::Shading().map_size;
  EXPECT_NEAR(edges[0], kSlope * kHeight - kHalf, tolerance);
  EXPECT_NEAR(edges[1], kSlope * kHeight + kHalf, tolerance);
}

}  // namespace
}  // namespace taut::hand_computed_test
