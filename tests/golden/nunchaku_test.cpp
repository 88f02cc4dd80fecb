// Golden frames of the nunchaku, one per caption, rendered from stored states: a fresh simulation
// of slack motion differs between machines.
//
// After a change that is meant, look at the pictures and take them over:
//   TAUT_ACCEPT_GOLDENS=1 ctest --preset release -R '^golden$'
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <utility>

#include "render/atomic_file.h"
#include "render/picture_difference.h"
#include "render/stage_renderer.h"
#include "scenes/scene.h"
#include "sim/simulation.h"

namespace taut {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

const fs::path kFolder = fs::path(TAUT_SOURCE_DIR) / "tests/golden/nunchaku";
constexpr int kWidth = 480, kHeight = 270;

struct Golden {
  std::string name;
  Snapshot state;
};

json as_json(const Vec3& v) {
  return json::array({v.x(), v.y(), v.z()});
}

Vec3 vec3(const json& v) {
  return Vec3(v.at(0).get<double>(), v.at(1).get<double>(), v.at(2).get<double>());
}

json as_json(const Golden& golden) {
  json connectors = json::array(), bodies = json::array();
  for (const auto& particles : golden.state.connectors) {
    json list = json::array();
    for (const Vec3& p : particles) list.push_back(as_json(p));
    connectors.push_back(list);
  }
  for (const Pose& body : golden.state.bodies) {
    const Quat& q = body.rotation;
    bodies.push_back(
        {{"position", as_json(body.position)}, {"rotation", {q.w(), q.x(), q.y(), q.z()}}});
  }
  return {{"name", golden.name},
          {"time", golden.state.time},
          {"connectors", connectors},
          {"bodies", bodies}};
}

Golden golden_from(const json& entry) {
  Golden golden{entry.at("name"), {entry.at("time"), {}, {}}};
  for (const json& connector : entry.at("connectors")) {
    auto& particles = golden.state.connectors.emplace_back();
    for (const json& p : connector) particles.push_back(vec3(p));
  }
  for (const json& body : entry.at("bodies")) {
    const json& q = body.at("rotation");
    golden.state.bodies.push_back(
        {vec3(body.at("position")), Quat(q.at(0).get<double>(), q.at(1).get<double>(),
                                         q.at(2).get<double>(), q.at(3).get<double>())});
  }
  return golden;
}

class GoldenNunchaku : public testing::Test {
 protected:
  void SetUp() override {
    static bool accepting = std::getenv("TAUT_ACCEPT_GOLDENS") != nullptr;
    if (std::exchange(accepting, false)) accept();
    std::ifstream file(kFolder / "states.json");
    ASSERT_TRUE(file) << kFolder / "states.json is missing";
    const json manifest = json::parse(file);
    renderer_description_ = manifest.at("renderer");
    for (const json& entry : manifest.at("states")) goldens_.push_back(golden_from(entry));
    ASSERT_FALSE(goldens_.empty());
  }

  Picture render(const Snapshot& state) {
    Instant instant{state, {}, camera_at(*scene_.stage, state.time)};
    for (const auto& performance : scene_.performances)
      instant.bones.push_back(performance->bones_at(state.time));
    renderer_.clear(canvas_);
    renderer_.draw(canvas_, {0, 0, kWidth, kHeight}, instant);
    return canvas_.finish();
  }

  /// The tier that can be asked for here: bits depend on the driver and the processor's vectors.
  bool matches(const PictureDifference& d) const {
    return context_.description() == renderer_description_ ? same_rendering(d) : same_picture(d);
  }

  Scene scene_ = load_scene(fs::path(TAUT_SOURCE_DIR) / "scenes/nunchaku.toml", true);
  Context context_{Backend::automatic};
  Canvas canvas_{context_, kWidth, kHeight, 4};
  StageRenderer renderer_{context_, *scene_.stage, scene_.world};
  std::vector<Golden> goldens_;
  std::string renderer_description_;

 private:
  /// The state in the middle of each caption's phase, and what it looks like today.
  void accept() {
    Simulation simulation(scene_.world, make_method(scene_.method.name, scene_.method.settings));
    fs::remove_all(kFolder);
    json states = json::array();
    int frame = 0;
    for (const Caption& caption : scene_.stage->captions) {
      const int wanted = int(std::lround((caption.from + caption.until) / 2 * scene_.fps));
      while (frame < wanted) simulation.advance_to(double(++frame) / scene_.fps);
      const Golden golden{fmt::format("frame_{:04}", frame), snapshot(simulation.world())};
      states.push_back(as_json(golden));
      const auto bytes = encode_png(render(golden.state));
      AtomicFile picture(kFolder / (golden.name + ".png"));
      picture.write({reinterpret_cast<const char*>(bytes.data()), bytes.size()});
      picture.commit();
    }
    AtomicFile file(kFolder / "states.json");
    file.write(json{{"renderer", context_.description()}, {"states", states}}.dump(1) + "\n");
    file.commit();
  }
};

TEST_F(GoldenNunchaku, PhasesLookAsAccepted) {
  for (const Golden& golden : goldens_) {
    const PictureDifference d =
        difference(render(golden.state), read_png(kFolder / (golden.name + ".png")));
    EXPECT_TRUE(matches(d)) << golden.name << ": " << 100 * d.above_2
                            << "% of pixels differ, at most by " << d.largest << ", mean shift "
                            << d.mean_shift << "; " << 100 * d.near_above_8
                            << "% have no like pixel next to them";
  }
}

TEST_F(GoldenNunchaku, SameBitsTwice) {
  const Picture first = render(goldens_[0].state);
  EXPECT_EQ(first.pixels, render(goldens_[0].state).pixels);
}

TEST_F(GoldenNunchaku, AStickThreePixelsOffIsSeen) {
  for (const Golden& golden : goldens_) {
    const CameraView camera = camera_at(*scene_.stage, golden.state.time);
    Snapshot moved = golden.state;
    Pose& stick = moved.bodies.back();
    const Vec3 forward = (camera.target - camera.position).normalized();
    const double depth = (stick.position - camera.position).dot(forward);
    const double pixel = 2 * depth * std::tan(camera.field_of_view / 2) / kHeight;  // m
    stick.position += 3 * pixel * forward.cross(Vec3::UnitY()).normalized();
    const PictureDifference d =
        difference(render(moved), read_png(kFolder / (golden.name + ".png")));
    EXPECT_FALSE(matches(d)) << golden.name;
  }
}

TEST_F(GoldenNunchaku, AWeakerLightIsSeen) {
  Stage dimmed = *scene_.stage;
  dimmed.light.color *= 0.98;
  StageRenderer renderer(context_, dimmed, scene_.world);
  const Snapshot& state = goldens_[0].state;
  Instant instant{state, {}, camera_at(dimmed, state.time)};
  for (const auto& performance : scene_.performances)
    instant.bones.push_back(performance->bones_at(state.time));
  renderer.clear(canvas_);
  renderer.draw(canvas_, {0, 0, kWidth, kHeight}, instant);
  const Picture golden = read_png(kFolder / (goldens_[0].name + ".png"));
  EXPECT_FALSE(same_rendering(difference(canvas_.finish(), golden)));
}

TEST(PictureDifference, Measures) {
  Picture a(100, 100), b(100, 100);
  EXPECT_TRUE(same_rendering(difference(a, b)));
  b.at(50, 50)[1] = 252;  // 3 off, in one pixel of 10,000
  EXPECT_DOUBLE_EQ(difference(a, b).above_2, 1e-4);
  EXPECT_TRUE(same_rendering(difference(a, b)));
  b.at(10, 10)[0] = 200;
  const PictureDifference d = difference(a, b);
  EXPECT_EQ(d.largest, 55);
  EXPECT_FALSE(same_rendering(d));
  // A pixel that only moved by one is found again; one that moved by two is not.
  Picture c(100, 100), moved(100, 100), far(100, 100);
  for (Picture* p : {&c, &moved, &far})
    p->at(50 + int(p == &moved) + 2 * int(p == &far), 50)[2] = 0;
  EXPECT_EQ(difference(moved, c).near_above_8, 0);
  EXPECT_GT(difference(far, c).near_above_8, 0);
  EXPECT_THROW(difference(a, Picture(10, 10)), std::invalid_argument);
}

}  // namespace
}  // namespace taut
