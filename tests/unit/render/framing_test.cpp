// Cameras that are turned and zoomed to what they show.
#include <gtest/gtest.h>

#include <vector>

#include "render/draw/shading/lighting.h"
#include "render/film/comparison.h"

namespace taut::framing_test {
namespace {

const std::vector<Vec3> kMoves = {
    {0, 0.4, 0}, {0.02, 0.8, 0.05}, {-0.1, 0.6, -0.05}, {0.1, 0.5, 0}};

/// Where points lie in the picture: 0 to 1 from the left and from below.
Eigen::AlignedBox2d places(const scenes::CameraView& camera, double aspect) {
  Eigen::AlignedBox2d box;
  for (const Vec3& p : kMoves) {
    const Eigen::Vector4f q =
        draw::camera_projection(camera, aspect) * p.cast<float>().homogeneous();
    box.extend(
        Eigen::Vector2d(0.5 + 0.5 * double(q.x() / q.w()), 0.5 + 0.5 * double(q.y() / q.w())));
  }
  return box;
}

TEST(Framing, WhatMovesFillsThePictureUnderItsHeading) {
  const scenes::CameraView camera{Vec3(0.24, 0.7, 1.2), Vec3(0.5, 0.2, 0), 1.2};
  for (const double aspect : {0.3, 1.0, 2.5}) {
    const Eigen::AlignedBox2d box = places(film::framed(camera, kMoves, aspect, 0.2), aspect);
    EXPECT_GT(box.min().minCoeff(), 0.07) << aspect;
    EXPECT_LT(box.max().x(), 0.93) << aspect;
    EXPECT_LT(box.max().y(), 0.73) << aspect;
    const bool tall = box.sizes().y() > 0.63, broad = box.sizes().x() > 0.83;
    EXPECT_TRUE(tall || broad) << aspect << ": " << box.sizes().transpose();
  }
}

TEST(Framing, NothingToShowLeavesTheCamera) {
  const scenes::CameraView camera{Vec3(0, 0, 1), Vec3::Zero(), 0.5};
  const std::vector<Vec3> behind = {{0, 0, 3}};
  EXPECT_EQ(film::framed(camera, behind, 1, 0).field_of_view, 0.5);
}

TEST(Framing, AMetreIsAsManyPixelsAsItIsDrawnWith) {
  const scenes::CameraView camera{Vec3(0, 1, 4), Vec3(0, 1, 0), 0.4};
  const Eigen::Matrix4f projection = draw::camera_projection(camera, 1);
  const auto height = [&](double y) {
    const Eigen::Vector4f q = projection * Eigen::Vector4f(0, float(y), 0, 1);
    return 500 * double(q.y() / q.w());
  };
  EXPECT_NEAR(height(1.5) - height(0.5), film::pixels_per_metre(camera, 1000), 0.1);
}

TEST(Framing, LengthsAreRound) {
  EXPECT_DOUBLE_EQ(film::round_length(0.19), 0.1);
  EXPECT_DOUBLE_EQ(film::round_length(0.21), 0.2);
  EXPECT_DOUBLE_EQ(film::round_length(9), 5);
}

}  // namespace
}  // namespace taut::framing_test
