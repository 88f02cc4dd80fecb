// Free bodies that touch obstacles, in scenes: what they are read as, and what is said against
// them.
#include <gtest/gtest.h>

#include "scenes/files/error.h"
#include "scenes/load/load_scene.h"
#include "sim/run/method.h"
#include "tests/support/folder.h"

namespace taut::body_contact_scene_test {
namespace {

const std::string kStick = "shape = { cylinder = { length = 0.3, diameter = 0.02 } }\n";
const std::string kAbove = "position = [0, 1, 0]\n";

std::string stick_with(const std::string& keys, const std::string& method = "direct") {
  return "duration = 1.0\n[method]\nname = \"" + method + "\"\n[bodies.stick]\nmass = 0.1\n" +
         keys + "\n[obstacles.floor]\nshape = { plane = {} }\n";
}

class BodyContactScene : public testing::Test {
 protected:
  World read(const std::string& text) const {
    return scenes::load_scene(folder_.write("scene.toml", text), false).world;
  }
  void expect(const std::string& text, const std::string& words) const {
    try {
      read(text);
      ADD_FAILURE() << "nothing is said: " << words;
    } catch (const scenes::BadScene& error) {
      const std::string message = error.what();
      EXPECT_NE(message.find("scene.toml:"), std::string::npos) << message;
      EXPECT_NE(message.find(words), std::string::npos) << message;
    }
  }

  Folder folder_;
};

TEST_F(BodyContactScene, IsReadAsItSays) {
  EXPECT_FALSE(has_touching_bodies(read(stick_with(kStick + kAbove))));
  const World world = read(stick_with(kStick + kAbove + "contact = {}"));
  EXPECT_TRUE(has_touching_bodies(world));
  const BodyCapsule& fits = world.bodies[0].capsule;
  EXPECT_DOUBLE_EQ(fits.radius, 0.01);
  EXPECT_LT((fits.from + 0.14 * Vec3::UnitY()).norm(), 1e-15);
  EXPECT_LT((fits.to - 0.14 * Vec3::UnitY()).norm(), 1e-15);
  const BodyCapsule ball =
      read(stick_with("shape = { sphere = { diameter = 0.1 } }\ncontact = {}\n" + kAbove))
          .bodies[0]
          .capsule;
  EXPECT_DOUBLE_EQ(ball.radius, 0.05);
  EXPECT_TRUE(ball.from.isZero(0) && ball.to.isZero(0));
  const BodyCapsule own = read(stick_with("inertia = [1, 1, 1]\n" + kAbove +
                                          "contact = { radius = 0.02, from = [0, -0.1, 0], "
                                          "to = [0.1, 0.2, 0] }"))
                              .bodies[0]
                              .capsule;
  EXPECT_EQ(own.to, Vec3(0.1, 0.2, 0));
  EXPECT_DOUBLE_EQ(own.radius, 0.02);
}

TEST_F(BodyContactScene, FaultsAreNamed) {
  const std::string box = "shape = { box = { size = [1, 1, 1] } }\nposition = [0, 9, 0]\n";
  expect(stick_with(box + "contact = {}"), "bodies.stick.contact: radius is missing");
  expect(stick_with(box + "contact = { radius = 1 }"), "from and to are missing");
  expect(stick_with(box + "contact = { radius = 1, to = [0, 1, 0] }"), "needs from");
  expect(stick_with(box + "contact = { radius = 0, from = [0, 0, 0], to = [0, 1, 0] }"),
         "contact.radius");
  expect(stick_with(kStick + kAbove + "contact = { radius = 0.2 }"),
         "which a cylinder shorter than 0.4 m gives no line");
  expect(stick_with(kStick + "position = [0, 0.1, 0]\ncontact = {}"),
         "bodies.stick.contact: starts 0.05 m inside of obstacle floor");
  expect(stick_with(kStick + "contact = {}\ndriven_by = { path = \"hand\" }\n"
                             "[paths.hand]\nkeys = [{ t = 0, position = [0, 1, 0] }]"),
         "needs a free body, without driven_by");
}

TEST_F(BodyContactScene, OtherMethodsAreRefused) {
  for (const MethodInfo& method : all_methods()) {
    if (!method.missing.empty()) continue;
    const std::string text = stick_with(kStick + kAbove + "contact = {}", std::string(method.name));
    if (method.touches_with_bodies) {
      EXPECT_TRUE(follows(method, read(text))) << method.name;
    } else {
      expect(text,
             method.touches_obstacles
                 ? "follows no free bodies that touch obstacles, expected one of: direct, truth"
                 : "knows no contact");
    }
  }
}

}  // namespace
}  // namespace taut::body_contact_scene_test
