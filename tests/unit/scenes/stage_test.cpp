// The camera's way, and the plain shapes of bodies without a mesh.
#include "scenes/scene/stage.h"

#include <gtest/gtest.h>

#include <map>
#include <numbers>

namespace taut::stage_test {
namespace {

TEST(Camera, PassesThroughItsKeysAndRestsBeyond) {
  const std::vector<scenes::CameraKey> keys = {{1, {0, 0, 5}, {0, 0, 0}, 0.5},
                                               {2, {1, 0, 5}, {0, 1, 0}, 0.7},
                                               {4, {5, 0, 5}, {0, 0, 0}, 0.6}};
  for (const scenes::CameraKey& key : keys) {
    const scenes::CameraView view = scenes::camera_at(keys, key.time);
    EXPECT_EQ(view.position, key.position);
    EXPECT_EQ(view.target, key.target);
    EXPECT_EQ(view.field_of_view, key.field_of_view);
  }
  EXPECT_EQ(scenes::camera_at(keys, -1).position, Vec3(0, 0, 5));
  EXPECT_EQ(scenes::camera_at(keys, 9).position, Vec3(5, 0, 5));
}

TEST(Camera, StartsAndStopsGentlyAndHasNoJumpInSpeed) {
  const std::vector<scenes::CameraKey> keys = {{0, {0, 0, 5}, {0, 0, 0}, 0.5},
                                               {1, {1, 0, 5}, {0, 0, 0}, 0.5},
                                               {3, {4, 0, 5}, {0, 0, 0}, 0.5}};
  const double h = 1e-6;
  const auto x = [&](double t) { return scenes::camera_at(keys, t).position.x(); };
  for (const double t : {0.0, 1.0, 3.0}) {
    EXPECT_NEAR((x(t) - x(t - h)) / h, (x(t + h) - x(t)) / h, 1e-4) << t;
  }
  EXPECT_NEAR((x(1 + h) - x(1 - h)) / (2 * h), 4.0 / 3, 1e-6);
}

TEST(Camera, ALensOpensAndFocusesSmoothlyAndByDefaultAtTheTarget) {
  std::vector<scenes::CameraKey> keys = {{0, {0, 0, 5}, {0, 0, 1}, 0.5},
                                         {2, {0, 0, 5}, {0, 0, 3}, 0.5}};
  EXPECT_EQ(scenes::camera_at(keys, 1).relative_aperture, 0);
  EXPECT_DOUBLE_EQ(scenes::camera_at(keys, 0).focus, 4);
  EXPECT_DOUBLE_EQ(scenes::camera_at(keys, 1).focus, 3);
  keys[1].relative_aperture = 0.5;
  keys[1].focus = 8;
  EXPECT_DOUBLE_EQ(scenes::camera_at(keys, 1).relative_aperture, 0.25);
  EXPECT_DOUBLE_EQ(scenes::camera_at(keys, 1).focus, 6);
  EXPECT_DOUBLE_EQ(scenes::camera_at(keys, 2).focus, 8);
}

TEST(Camera, GoesRoundItsTargetBetweenOrbits) {
  std::vector<scenes::CameraKey> keys(2);
  keys[0].orbit = Vec3(0, 0.3, 4);
  keys[1].orbit = Vec3(std::numbers::pi, 0.3, 4);
  for (std::size_t k = 0; k < 2; ++k) {
    keys[k].time = double(k);
    keys[k].target = Vec3(1, 1, 0);
    keys[k].position = keys[k].target + scenes::on_orbit(*keys[k].orbit);
  }
  EXPECT_LT((keys[0].position - Vec3(1, 1 + 4 * std::sin(0.3), 4 * std::cos(0.3))).norm(), 1e-12);
  for (const double time : {0.0, 0.2, 0.5, 0.9, 1.0}) {
    const scenes::CameraView view = scenes::camera_at(keys, time);
    EXPECT_NEAR((view.position - view.target).norm(), 4, 1e-12) << time;
  }
  const Vec3 half = scenes::camera_at(keys, 0.5).position;
  EXPECT_LT((half - Vec3(1 + 4 * std::cos(0.3), 1 + 4 * std::sin(0.3), 0)).norm(), 1e-12);
  keys[1].orbit.reset();  // straight, where one has a position alone
  EXPECT_NEAR(scenes::camera_at(keys, 0.5).position.x(), 1, 1e-12);
}

/// Volume of a mesh by the divergence theorem; right and positive only where it is closed and its
/// triangles face outward. Every edge must be met once in each direction.
double closed_volume(const scenes::Model& model) {
  const scenes::Mesh& mesh = model.meshes.at(0);
  using Point = std::array<float, 3>;
  std::map<std::pair<Point, Point>, int> edges;
  double volume = 0;
  for (std::size_t t = 0; t < mesh.indices.size(); t += 3) {
    Vec3 corner[3], normal = Vec3::Zero();
    for (std::size_t k = 0; k < 3; ++k) {
      const scenes::Vertex& v = mesh.vertices[mesh.indices[t + k]];
      const scenes::Vertex& next = mesh.vertices[mesh.indices[t + (k + 1) % 3]];
      corner[k] = Vec3(v.position[0], v.position[1], v.position[2]);
      normal += Vec3(v.normal[0], v.normal[1], v.normal[2]);
      if (v.position != next.position) {
        ++edges[{v.position, next.position}];
        --edges[{next.position, v.position}];
      }
    }
    const Vec3 face = (corner[1] - corner[0]).cross(corner[2] - corner[0]);
    EXPECT_GE(face.dot(normal), 0) << "normals point outward too";
    volume += corner[0].dot(corner[1].cross(corner[2])) / 6;
  }
  for (const auto& [edge, count] : edges) EXPECT_EQ(count, 0);
  return volume;
}

TEST(Shapes, AreClosedAndFaceOutward) {
  const double pi = std::numbers::pi;
  // Inscribed: 48 sides have 0.9971 of the circle's area, and so have the ball's 24 rings of their
  // sphere's profile, once more and a half.
  EXPECT_NEAR(closed_volume(scenes::cylinder_model(0.3, 0.02, Vec3::Ones())),
              0.3 * pi * 1e-4 * 0.9971, 1e-8);
  EXPECT_NEAR(closed_volume(scenes::sphere_model(0.2, Vec3::Ones())), 4 * pi / 3 * 1e-3 * 0.9929,
              1e-6);
  EXPECT_NEAR(closed_volume(scenes::box_model({0.1, 0.2, 0.3}, Vec3::Ones())), 0.006, 1e-8);
}

}  // namespace
}  // namespace taut::stage_test
