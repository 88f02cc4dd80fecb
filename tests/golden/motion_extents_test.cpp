// The parts of a moving mesh drawn once, and those drawn in every exposure.
#include "render/draw/motion_extents.h"

#include <gtest/gtest.h>

#include <cmath>

#include "render/draw/shading/lighting.h"
#include "render/draw/stage_parts.h"
#include "render/gl/context.h"

namespace taut::motion_extents_test {
namespace {

using Eigen::Matrix4f;
using Eigen::Vector3f;

/// A ribbon of `columns` squares of 10 cm along x, at z = 0, facing the camera on +z.
struct Ribbon {
  explicit Ribbon(const gl::Gl& gl, std::uint32_t columns)
      : drawable(gl, std::make_shared<const draw::RestShape>(gl, indices(columns), rest(columns)),
                 scenes::Material{}, draw::Surface::plain) {}

  static std::vector<mesh::RestVertex> rest(std::uint32_t columns) {
    std::vector<mesh::RestVertex> result;
    for (std::uint32_t i = 0; i <= columns; ++i)
      for (const float y : {0.0f, 0.1f})
        result.push_back({Vector3f(0.1f * float(i), y, 0), Vector3f::Ones()});
    return result;
  }
  static std::vector<std::uint32_t> indices(std::uint32_t columns) {
    std::vector<std::uint32_t> result;
    for (std::uint32_t i = 0; i < 2 * columns; i += 2)
      for (const std::uint32_t v : {i, i + 2, i + 1, i + 1, i + 2, i + 3}) result.push_back(v);
    return result;
  }
  /// Each vertex moved by what `offset` says of its x.
  template <typename Offset>
  void move(std::uint32_t columns, Offset offset) {
    std::vector<mesh::MovingVertex> vertices;
    for (const mesh::RestVertex& v : rest(columns))
      vertices.push_back({v.rest + offset(v.rest.x()), Vector3f::UnitZ()});
    drawable.move(vertices);
  }
  draw::Drawable drawable;
};

class MotionExtentsTest : public testing::Test {
 protected:
  static constexpr picture::Rect kView{0, 0, 1000, 1000};
  // A metre at z = 0 is 1000 / (2 * 4 tan 0.25) pixels.
  const Matrix4f projection_ = draw::camera_projection({Vec3(0, 0, 4), Vec3::Zero(), 0.5}, 1);
  const double metre_ = 1000 / (8 * std::tan(0.25));
  gl::Context context_{gl::Backend::automatic};
  Ribbon ribbon_{context_.gl(), 10};
  draw::MotionExtents extents_;
  std::vector<std::vector<draw::Places>> places_;  // [time][item]

  /// The items as they are now, a millisecond after they were added last.
  void add(std::span<const draw::DrawItem> items) {
    auto& places = places_.emplace_back();
    for (const draw::DrawItem& item : items) places.push_back(draw::places_of(item));
    std::vector<double> times;
    for (std::size_t i = 1; i <= places_.size(); ++i) times.push_back(0.001 * double(i));
    extents_.start(items, times, [this](std::size_t time, std::size_t item, draw::Places& at) {
      at = places_[time][item];
    });
  }
  template <typename Offset>
  void add(Offset offset) {
    ribbon_.move(10, offset);
    const draw::DrawItem item(ribbon_.drawable, Matrix4f::Identity());
    add(std::span(&item, 1));
  }
};

TEST_F(MotionExtentsTest, TravelIsTheWayOfTheFastestPoint) {
  // Up and down again: the way counts, not where it ends.
  add([](float) { return Vector3f(Vector3f::Zero()); });
  add([](float x) { return Vector3f(0, 0.05f * x, 0); });
  add([](float) { return Vector3f(Vector3f::Zero()); });
  const draw::MotionExtents::Travel travel = extents_.find_moving(projection_, kView);
  EXPECT_NEAR(travel.way, 2 * 0.05 * metre_, 0.01);
  EXPECT_NEAR(travel.speed, 0.05 * metre_ / 0.001, 10);
}

TEST_F(MotionExtentsTest, TheBorderIsInBothParts) {
  const auto bend = [](float by) {
    return [by](float x) { return Vector3f(0, x > 0.65f ? by : 0.0f, 0); };
  };
  add(bend(-0.02f));
  add(bend(0));
  add(bend(0.02f));
  extents_.find_moving(projection_, kView);
  extents_.grade({});
  extents_.divide();
  // Squares 0 to 5 stand, 7 to 9 move, and 6 has corners of both.
  EXPECT_EQ(extents_.casting(0, 0).size(), 7u * 6);
  EXPECT_EQ(extents_.moving(0, 1).size(), 4u * 6);
  EXPECT_EQ(extents_.moving(0, 1).front(), 12u);
  const Eigen::AlignedBox3f box = extents_.moving_box(0);
  EXPECT_LE(box.min().y(), -0.02f);
  EXPECT_GE(box.max().y(), 0.12f);
  EXPECT_GT(box.min().x(), 0.5f);
}

TEST_F(MotionExtentsTest, GradesAreOfSpeed) {
  const auto bend = [](float by) {
    return [by](float x) { return Vector3f(0, x > 0.85f ? 10 * by : x > 0.45f ? by : 0.0f, 0); };
  };
  for (const float by : {-0.01f, 0.0f, 0.01f}) add(bend(by));
  extents_.find_moving(projection_, kView);
  const double slow = 0.01 * metre_ / 0.001;  // px/s
  const double limits[] = {2 * slow};
  extents_.grade(limits);
  extents_.divide();
  // Squares 0 to 3 stand, 5 to 7 are slow, 9 is fast; 4 and 8 are on borders.
  EXPECT_EQ(extents_.plain(0, 0).size(), 5u * 6);
  EXPECT_EQ(extents_.plain(0, 1).size(), 5u * 6);
  EXPECT_EQ(extents_.plain(0, 2).size(), 2u * 6);
  EXPECT_TRUE(extents_.swept(0, 0).empty());
  EXPECT_GT(extents_.casting_box(0, 2).min().x(), 0.75f);
  EXPECT_LT(extents_.moving_box(0).min().x(), 0.45f);
}

TEST_F(MotionExtentsTest, WhatMovesSweepsWhereItsShadowFalls) {
  // A second ribbon stands behind the moving end of the first, as the light sees it.
  Ribbon behind(context_.gl(), 10);
  behind.move(10, [](float) { return Vector3f(0, 0, -0.5f); });
  for (const float by : {-0.02f, 0.0f, 0.02f}) {
    ribbon_.move(10, [by](float x) { return Vector3f(0, x > 0.65f ? by : 0.0f, 0); });
    const draw::DrawItem items[] = {{ribbon_.drawable, Matrix4f::Identity()},
                                    {behind.drawable, Matrix4f::Identity()}};
    add(std::span<const draw::DrawItem>(items));
  }
  extents_.find_moving(projection_, kView);
  draw::ShadowCover cover;
  const Eigen::AlignedBox3d casters(Vec3(0, -0.1, -0.6), Vec3(1, 0.2, 0.1));
  cover.start(draw::light_map(Vec3(0, 0, -1), casters, 1024).projection, 0.001f, 0);
  const double limits[] = {0.001};  // px/s: everything that moves is faster
  extents_.grade(limits);
  extents_.sweep(cover, 2, 2);
  extents_.sweep(cover, 1, 1);
  extents_.divide();
  EXPECT_TRUE(extents_.moving(1, 1).empty());
  EXPECT_TRUE(extents_.swept(0, 2).empty());
  EXPECT_EQ(extents_.plain(1, 0).size() + extents_.swept(1, 0).size(), 10u * 6);
  Eigen::AlignedBox3f swept;
  for (const std::uint32_t v : extents_.swept(1, 0)) swept.extend(behind.drawable.positions()[v]);
  EXPECT_GT(swept.min().x(), 0.35f);
  EXPECT_GE(swept.max().x(), 1.0f);
}

}  // namespace
}  // namespace taut::motion_extents_test
