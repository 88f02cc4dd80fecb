#include "scenes/load/default_stage.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include "scenes/format/document.h"
#include "scenes/load/load_scene.h"
#include "scenes/scene/stage.h"
#include "sim/motion/stop.h"

namespace taut::scenes {
namespace {

constexpr double kFieldOfView = 0.5;  // rad, vertical
constexpr double kFilled = 0.8;       // of the picture, by what moves
constexpr double kRise = 0.2;         // rad, of the camera above what it looks at
constexpr double kAside = 0.3;        // rad, from the square look, so that depth is seen
constexpr double kRunaway = 10;       // times the size at the start: farther off is not framed
constexpr double kSmallest = 0.05;    // m, half of what is framed
constexpr double kHead = 0.15;        // m, of a character around its bones
constexpr double kPin = 2.5;  // diameters of its connector, of a ball that shows a fixed end
constexpr std::size_t kMostPins = 200;  // and rods
constexpr double kWall = 1.5;           // times the camera's distance, of the wall around all
/// Of the simulation that finds what to frame, as Counters::cycles has it: a few seconds.
constexpr double kMostCycles = 1e10;
constexpr std::uint64_t kMostChecks = 20'000'000;  // calls of check_stop(), within frames too
constexpr std::size_t kMostPoints = 20'000'000;

using Box = Eigen::AlignedBox3d;

Box box_of(const Model& model) {
  Box box;
  for (const Mesh& mesh : model.meshes)
    for (const Vertex& v : mesh.vertices)
      box.extend(Vec3(double(v.position[0]), double(v.position[1]), double(v.position[2])));
  return box;
}

/// The box that has the body's mass and inertia, in the body's frame.
Box box_of(const MassProperties& properties) {
  Box box;
  for (const Vec3& middle : box_ends(properties)) box.extend(middle);
  return box;
}

/// Of the ball that a point mass at the particle is drawn as: steel of that mass; 0: there is none.
double radius_at(const Connector& connector, std::size_t particle) {
  constexpr double kSteel = 7850;  // kg/m^3
  for (const Hold& hold : connector.holds)
    if (hold.particle == particle) return 0;
  const double own = connector.mass / static_cast<double>(connector.particles());
  const double extra = std::max(connector.particle_mass[particle] - own, 0.0);
  return std::cbrt(3 * extra / (4 * std::numbers::pi * kSteel));
}

/// The boxes of a scene's bodies, as their models or their inertia have them, in their frames.
std::vector<Box> boxes_of(const Scene& scene) {
  std::vector<Box> boxes;
  for (std::size_t b = 0; b < scene.world.bodies.size(); ++b) {
    const Model* model = scene.stage ? scene.stage->body_models.at(b).get() : nullptr;
    boxes.push_back(model ? box_of(*model) : box_of(scene.world.bodies[b].bare));
  }
  return boxes;
}

std::vector<Vec3> corners(const Box& box, const Pose& frame) {
  std::vector<Vec3> all;
  for (int corner = 0; corner < 8; ++corner)
    all.push_back(frame.to_world(box.corner(static_cast<Box::CornerType>(corner))));
  return all;
}

/// Everything there is to see of a scene, state by state.
class Seen {
 public:
  explicit Seen(const Scene& scene) : scene_(scene), boxes_(boxes_of(scene)) {}

  std::vector<Vec3> points(const Snapshot& state) const {
    std::vector<Vec3> all;
    for (const auto& particles : state.connectors)
      all.insert(all.end(), particles.begin(), particles.end());
    for (std::size_t c = 0; c < scene_.world.connectors.size(); ++c) {
      for (const std::size_t end : {std::size_t(0), scene_.world.connectors[c].particles() - 1})
        for (const Vec3& way : {Vec3(Vec3::UnitX()), Vec3(Vec3::UnitY()), Vec3(Vec3::UnitZ())})
          for (const double side : {-1.0, 1.0})
            all.push_back(state.connectors[c][end == 0 ? 0 : state.connectors[c].size() - 1] +
                          side * radius_at(scene_.world.connectors[c], end) * way);
    }
    for (std::size_t b = 0; b < state.bodies.size(); ++b) {
      const std::vector<Vec3> own = corners(boxes_.at(b), state.bodies[b]);
      all.insert(all.end(), own.begin(), own.end());
    }
    return all;
  }

  std::vector<Vec3> figures(double time) const {
    std::vector<Vec3> all;
    for (const auto& performance : scene_.performances)
      for (const Pose& bone : performance->bones_at(time))
        for (const double side : {-kHead, kHead})
          all.push_back(bone.position + side * Vec3::UnitY());
    return all;
  }

 private:
  const Scene& scene_;
  std::vector<Box> boxes_;
};

/// What the clip shows, as far as it was looked at.
struct Points {
  std::vector<Vec3> all;  // m, runaways aside
  int frames = 0;         // of the scene's, from the start
};

/// The points that the clip shows. What a look may take is counted, not timed, so that all machines
/// see the same: work of the method and points that are kept.
Points points_of_clip(const Scene& scene, const std::function<void()>& tick) {
  const Seen seen(scene);
  Simulation simulation = start(scene);
  Points found;
  std::vector<Vec3>& all = found.all;
  Box near;
  const WorkLimit limit({.checks = kMostChecks});
  try {
    for (int& frame = found.frames; frame < scene.frames(); ++frame) {
      tick();
      if (all.size() > kMostPoints || simulation.method().counters().cycles > kMostCycles) break;
      const double time = static_cast<double>(frame) / scene.fps;
      simulation.advance_to(time);
      std::vector<Vec3> points = seen.points(simulation.state());
      for (const Body& body : simulation.world().bodies)
        if (body.driven()) near.extend(body.position);
      for (const Connector& connector : simulation.world().connectors)
        for (const Hold& hold : connector.holds)
          if (hold.to.kind != Attachment::Kind::body)
            near.extend(connector.position[hold.particle]);
      if (frame == 0)
        for (const Vec3& point : points) near.extend(point);
      all.insert(all.end(), points.begin(), points.end());
      if (frame % std::max(scene.fps / 10, 1) == 0) {
        points = seen.figures(time);
        for (const Vec3& point : points) near.extend(point);
        all.insert(all.end(), points.begin(), points.end());
      }
    }
  } catch (const Diverged&) {  // the clip ends there, too
    found.frames = scene.frames();
  } catch (const OverLimit&) {
    if (!limit.reached()) throw;
  }
  const double range = kRunaway * std::max(near.diagonal().norm() / 2, kSmallest);
  std::erase_if(all, [&](const Vec3& point) {
    return !point.allFinite() || near.exteriorDistance(point) > range;
  });
  return found;
}

/// The way to look: level, across the plane in which most happens, from the front.
Vec3 way_to_look(const std::vector<Vec3>& points) {
  Eigen::Vector2d mean(0, 0);
  for (const Vec3& p : points) mean += Eigen::Vector2d(p.x(), p.z()) / double(points.size());
  Eigen::Matrix2d spread = Eigen::Matrix2d::Zero();
  for (const Vec3& p : points) {
    const Eigen::Vector2d off = Eigen::Vector2d(p.x(), p.z()) - mean;
    spread += off * off.transpose();
  }
  // The eigenvalues of `spread` are middle +- apart, the larger one in the direction of `angle`.
  const double middle = (spread(0, 0) + spread(1, 1)) / 2;
  const double half = (spread(0, 0) - spread(1, 1)) / 2;
  const double apart = std::hypot(half, spread(0, 1));
  Vec3 back(0, 0, 1);  // towards the camera
  constexpr double kPlane = 0.5;
  if (middle - apart < kPlane * (middle + apart)) {
    const double angle = std::atan2(spread(0, 1), half) / 2;
    back = Vec3(-std::sin(angle), 0, std::cos(angle));
    if (back.z() < -1e-6 || (std::abs(back.z()) <= 1e-6 && back.x() < 0)) back = -back;
  }
  const Eigen::AngleAxisd aside(kAside, Vec3::UnitY());
  const Vec3 level = aside * back;
  return -(std::cos(kRise) * level + std::sin(kRise) * Vec3::UnitY()).normalized();
}

CameraKey framing(const std::vector<Vec3>& points, double aspect) {
  const Vec3 ahead = way_to_look(points), right = ahead.cross(Vec3::UnitY()).normalized(),
             up = right.cross(ahead);
  Mat3 axes;
  axes << right, up, -ahead;
  Box box;
  for (const Vec3& p : points) box.extend(axes.transpose() * p);
  const double half = std::tan(kFieldOfView / 2) * kFilled;
  const Vec3 centre = box.center();
  double distance = kSmallest / half;
  for (const Vec3& p : points) {
    const Vec3 off = axes.transpose() * p - centre;
    distance = std::max(distance,
                        off.z() + std::max(std::abs(off.x()) / aspect, std::abs(off.y())) / half);
  }
  CameraKey key;
  key.target = axes * centre;
  key.position = key.target - distance * ahead;
  key.field_of_view = kFieldOfView;
  return key;
}

void move(Model& model, const Vec3& by) {
  for (Vertex& vertex : model.meshes.front().vertices)
    for (std::size_t k = 0; k < 3; ++k)
      vertex.position[k] += static_cast<float>(by[static_cast<Eigen::Index>(k)]);
}

double wall_distance(const CameraKey& camera) {
  return kWall * (camera.position - camera.target).norm();
}

/// A round cove about the camera and what it looks at: a floor at `height` that bends up into a
/// wall, darker where it is farther from the middle, so that nothing of it has an edge.
std::shared_ptr<const Model> cove_at(double height, const CameraKey& camera) {
  constexpr int kSides = 96, kFloor = 28, kBend = 20, kWallRows = 6;
  const double distance = (camera.position - camera.target).norm();
  const double wall = wall_distance(camera), bend = 0.35 * wall;
  const double lit = 1.4 * std::tan(camera.field_of_view / 2) * distance;  // m, half of its width
  const Vec3 middle(camera.target.x(), height, camera.target.z());
  Mesh mesh;
  mesh.name = "cove";
  const auto row = [&](double out, double up, double normal_angle) {
    for (int side = 0; side <= kSides; ++side) {
      const double angle = 2 * std::numbers::pi * (side % kSides) / kSides;
      const Vec3 away(std::cos(angle), 0, -std::sin(angle));
      const std::uint32_t here =
          add_vertex(mesh, middle + out * away + up * Vec3::UnitY(),
                     std::cos(normal_angle) * Vec3::UnitY() - std::sin(normal_angle) * away);
      const double far = std::hypot(out / (1.6 * lit), up / (1.5 * lit));
      mesh.vertices[here].color.fill(static_cast<float>(0.55 + 0.45 * std::exp(-far * far / 2)));
      constexpr std::uint32_t kRow = kSides + 1;
      if (side > 0 && here >= kRow) add_quad(mesh, here - kRow - 1, here - 1, here, here - kRow);
    }
  };
  for (int i = 0; i < kFloor; ++i) row((wall - bend) * std::pow(double(i) / kFloor, 1.6), 0, 0);
  for (int i = 0; i <= kBend; ++i) {
    const double angle = std::numbers::pi / 2 * i / kBend;
    row(wall - bend + bend * std::sin(angle), bend * (1 - std::cos(angle)), angle);
  }
  for (int i = 1; i <= kWallRows; ++i)
    row(wall, bend + (wall - bend) * i / kWallRows, std::numbers::pi / 2);
  Model model;
  model.name = "cove";
  model.materials.push_back(
      {.name = "Backdrop", .base_color = {0.250F, 0.275F, 0.295F}, .roughness = 0.9F});
  model.meshes.push_back(std::move(mesh));
  return std::make_shared<const Model>(std::move(model));
}

/// The way of a light that comes over the right shoulder of whoever looks.
Vec3 over_the_shoulder(const CameraKey& camera) {
  Vec3 ahead = camera.target - camera.position;
  ahead.y() = 0;
  ahead.normalize();
  return 0.55 * ahead - 0.45 * ahead.cross(Vec3::UnitY()) - 0.75 * Vec3::UnitY();
}

/// How high the floor is (m): just over a level plane, which it hides, or below all points.
double floor_of(const Scene& scene, const std::vector<Vec3>& points, double size) {
  constexpr double kOver = 1e-4;  // of the size
  double thickest = 0;
  for (const ConnectorLook& look : scene.stage->connector_looks)
    thickest = std::max(thickest, look.diameter);
  double lowest = std::ranges::min(points, {}, [](const Vec3& p) { return p.y(); }).y();
  lowest -= thickest / 2;
  for (const Obstacle& o : scene.world.obstacles)
    if (o.shape.kind == Shape::Kind::plane && !o.path &&
        (o.place.rotation * Vec3::UnitY()).y() > 1 - 1e-9)
      lowest = o.place.position.y() + kOver * size;
  return lowest;
}

std::shared_ptr<const Model> rod(const Vec3& from, const Vec3& to, double radius,
                                 const Vec3& color) {
  const Vec3 along = to - from;
  return std::make_shared<const Model>(
      obstacle_model({.kind = Shape::Kind::cylinder, .radius = radius, .length = along.norm()}, 0,
                     {from + along / 2, Quat::FromTwoVectors(Vec3::UnitY(), along)}, color));
}

/// A steel ball at each fixed point that holds a connector. It hangs on a rod from above the
/// picture or, if something rises higher, sits on the arm of a post that stands behind it.
std::vector<std::shared_ptr<const Model>> pins_of(const Scene& scene, const CameraKey& camera,
                                                  double floor, double highest, double size) {
  constexpr double kHigher = 0.08;  // of the size
  constexpr double kBehind = 0.25;  // of the size, from a ball to its post
  std::vector<std::shared_ptr<const Model>> pins;
  const Vec3 steel(0.10, 0.10, 0.11);
  Vec3 back = camera.target - camera.position;
  back.y() = 0;
  back = Eigen::AngleAxisd(kAside, Vec3::UnitY()) * back.normalized();
  for (std::size_t c = 0; c < scene.world.connectors.size(); ++c) {
    const double thick = kPin * scene.stage->connector_looks.at(c).diameter;
    for (const Hold& hold : scene.world.connectors[c].holds) {
      if (hold.to.kind != Attachment::Kind::fixed) continue;
      const bool hangs = highest < hold.to.point.y() + kHigher * size;
      const Vec3 end = hold.to.point + (hangs ? Vec3(size * Vec3::UnitY()) : kBehind * size * back);
      Model ball = sphere_model(thick, steel);
      ball.name = "pin";
      move(ball, hold.to.point);
      pins.push_back(std::make_shared<const Model>(std::move(ball)));
      pins.push_back(rod(hold.to.point, end, thick / 4, steel));
      if (!hangs && end.y() > floor + thick)
        pins.push_back(rod({end.x(), floor, end.z()}, end, thick / 3, steel));
    }
  }
  return pins;
}

/// As thick as a fibre rope of its weight would be, a chain's links as wide; within what the
/// picture, `size` (m) wide, can show.
double thickness_of(const Connector& connector, ConnectorLook::Kind kind, double size) {
  constexpr double kFibre = 1000, kSteel = 7800;  // kg/m^3
  const bool chain = kind == ConnectorLook::Kind::chain;
  const double line = connector.length > 0 ? connector.mass / connector.length : 0;
  double diameter = std::sqrt(4 * line / (std::numbers::pi * (chain ? kSteel : kFibre)));
  if (chain) diameter *= 2.5;  // of a link against its wire
  return std::clamp(diameter, 0.014 * size, 0.03 * size);
}

/// The looks of connectors that the file says nothing of: copies and parts that cuts make are like
/// what they come from.
void find_looks(const Document& document, Scene& scene, double size) {
  using Kind = ConnectorLook::Kind;
  const Value *connectors = document.root.find("connectors"), *nets = document.root.find("nets");
  const auto find = [&](const std::string& name) {
    const Value* written = connectors ? connectors->find(name) : nullptr;
    return written || !nets ? written : nets->find(name);
  };
  const World world = divided(scene.world, scene.timeline);
  for (std::size_t i = 0; i < scene.stage->connector_looks.size(); ++i) {
    const Connector& connector = world.connectors.at(i);
    const Value* written = find(connector.name.substr(0, connector.name.find_first_of("#'")));
    if (!written) continue;
    ConnectorLook& look = scene.stage->connector_looks[i];
    const double line = connector.length > 0 ? connector.mass / connector.length : 0;
    if (!written->find("look") && !written->find("color")) {
      look.kind = line > 0.6 && !connector.winch ? Kind::chain
                  : line < 0.03                  ? Kind::cord
                                                 : Kind::rope;
      if (look.kind == Kind::chain) look.color = Vec3(0.45, 0.46, 0.48);
      if (look.kind == Kind::cord) look.color = Vec3(0.40, 0.05, 0.03);
    }
    const bool is_bead = written->find("radius") || !scene.world.obstacles.empty();
    if (!written->find("diameter") && !is_bead) {
      look.diameter = thickness_of(connector, look.kind, size);
    }
  }
}

/// Bodies without mesh and shape, as the boxes of their inertia.
void give_boxes(Scene& scene) {
  for (std::size_t b = 0; b < scene.world.bodies.size(); ++b) {
    auto& model = scene.stage->body_models.at(b);
    if (model) continue;
    const Box box = box_of(scene.world.bodies[b].bare);
    Model made = box_model(box.sizes().cwiseMax(1e-4), Vec3(0.25, 0.30, 0.36));
    for (Vertex& vertex : made.meshes.front().vertices)
      for (std::size_t k = 0; k < 3; ++k)
        vertex.position[k] += static_cast<float>(box.center()[static_cast<Eigen::Index>(k)]);
    model = std::make_shared<const Model>(std::move(made));
  }
}

}  // namespace

Outlines::Outlines(const Scene& scene) : boxes_(boxes_of(scene)) {
  const World world = divided(scene.world, scene.timeline);
  for (const Connector& connector : world.connectors)
    connectors_.push_back("connector " + connector.name);
  for (const Body& body : world.bodies) bodies_.push_back("body " + body.name);
}

std::vector<Outline> Outlines::of(const Snapshot& state) const {
  std::vector<Outline> all;
  for (std::size_t c = 0; c < state.connectors.size(); ++c)
    all.push_back({connectors_.at(c), state.connectors[c]});
  for (std::size_t b = 0; b < state.bodies.size(); ++b)
    all.push_back({bodies_.at(b), corners(boxes_.at(b), state.bodies[b])});
  return all;
}

namespace {

/// Where a followed thing goes, frame by frame, as somebody who leads a camera sees it: evened out.
class Way {
 public:
  Way(const World& world, const std::string& name) {
    const auto named = [&](const auto& things) {
      return static_cast<std::size_t>(
          std::ranges::find(things, name, [](const auto& t) { return t.name; }) - things.begin());
    };
    body_ = named(world.bodies);
    connector_ = named(world.connectors);
    is_body_ = body_ < world.bodies.size();
  }

  void add(const Snapshot& state) {
    if (is_body_) return places_.push_back(state.bodies[body_].position);
    Vec3 sum = Vec3::Zero();
    for (const Vec3& p : state.connectors[connector_]) sum += p;
    places_.push_back(sum / double(state.connectors[connector_].size()));
  }

  Vec3 at(double frame) const {
    if (places_.empty()) return Vec3::Zero();
    const double last = double(places_.size() - 1), held = std::clamp(frame, 0.0, last);
    const auto i = static_cast<std::size_t>(held);
    const Vec3& next = places_[std::min(i + 1, places_.size() - 1)];
    return places_[i] + (held - double(i)) * (next - places_[i]);
  }

  /// The mean around that frame, the nearer the heavier.
  Vec3 smooth(double frame, double frames) const {
    constexpr int kHalf = 6;
    Vec3 sum = Vec3::Zero();
    for (int k = 1 - kHalf; k < kHalf; ++k)
      sum += (kHalf - std::abs(k)) * at(frame + k * frames / kHalf);
    return sum / (kHalf * kHalf);
  }

 private:
  std::size_t body_ = 0, connector_ = 0;
  bool is_body_ = false;
  std::vector<Vec3> places_;
};

/// Gives cameras that follow something keys that do not.
void resolve_follow(Scene& scene, const std::function<void()>& tick) {
  constexpr double kEven = 0.2;        // s, on both sides
  constexpr double kApart = 1 / 15.0;  // s, between keys
  std::map<std::string, Way> ways;
  const auto note = [&](const std::vector<CameraKey>& keys) {
    if (!keys.empty() && !keys[0].follow.empty())
      ways.try_emplace(keys[0].follow, scene.world, keys[0].follow);
  };
  note(scene.stage->camera);
  for (const Shot& shot : scene.stage->shots) note(shot.camera);
  if (ways.empty()) return;

  Simulation simulation = start(scene);
  try {
    for (int frame = 0; frame < scene.frames(); ++frame) {
      tick();
      simulation.advance_to(static_cast<double>(frame) / scene.fps);
      const Snapshot state = simulation.state();
      for (auto& [name, way] : ways) way.add(state);
    }
  } catch (const Diverged&) {  // the clip ends there, too
  }
  const auto resolve = [&](std::vector<CameraKey>& keys, double from, double until) {
    if (keys.empty() || keys[0].follow.empty()) return;
    const Way& way = ways.at(keys[0].follow);
    std::vector<CameraKey> found;
    const int count = static_cast<int>(std::ceil((until - from) / kApart));
    for (int k = -1; k <= count + 1; ++k) {
      const double time = from + k * kApart;
      const Vec3 by = way.smooth(time * scene.fps, kEven * scene.fps);
      const CameraView view = camera_at(keys, time);
      CameraKey& key = found.emplace_back();
      key.time = time;
      key.target = view.target + by;
      key.position = view.position + (keys[0].orbit ? by : Vec3(Vec3::Zero()));
      key.field_of_view = view.field_of_view;
      key.relative_aperture = view.relative_aperture;
      if (keys[0].focus) key.focus = view.focus;
    }
    keys = std::move(found);
  };
  resolve(scene.stage->camera, 0, scene.duration);
  for (Shot& shot : scene.stage->shots) resolve(shot.camera, shot.from, shot.until);
}

}  // namespace

std::string complete_stage(Scene& scene, const std::vector<SceneChange>& changes,
                           const std::function<void()>& tick) {
  if (!scene.stage) {
    std::vector<SceneChange> staged = changes;
    staged.push_back({"stage", "{}"});
    Scene read = load_scene(scene.file, true, staged);
    scene.stage = std::move(read.stage);
    scene.stage->background = Vec3(0.62, 0.66, 0.70);
    scene.performances = std::move(read.performances);
  }
  resolve_follow(scene, tick);
  Stage& stage = *scene.stage;
  Document document = read_document(scene.file);
  for (const auto& [key, value] : changes) change(document, key, value);
  const Value* written = document.root.find("stage");
  if (written && written->find("camera")) return {};
  const auto [points, frames] = points_of_clip(scene, tick);
  std::string left_out;
  if (frames < scene.frames()) {
    left_out = fmt::format(
        "the camera frames what moves until {:.4g} s: more is too much to simulate for it; "
        "stage.camera sets another one",
        static_cast<double>(std::max(frames - 1, 0)) / scene.fps);
  }
  if (points.empty()) return left_out;
  constexpr double kFarthest = 1e15;  // m
  for (const Vec3& point : points) {
    if (point.cwiseAbs().maxCoeff() <= kFarthest) continue;
    document.fail(document.root,
                  fmt::format("what moves comes to {:.3g} m from the origin, expected at most {} m "
                              "in a picture",
                              point.cwiseAbs().maxCoeff(), kFarthest));
  }
  const CameraKey camera = framing(points, static_cast<double>(scene.width) / scene.height);
  if (!written || !written->find("light")) stage.light.direction = over_the_shoulder(camera);
  const Value* shots = written ? written->find("shots") : nullptr;
  stage.camera = {camera};
  for (std::size_t i = 0; i < stage.shots.size(); ++i)
    if (!shots || !shots->children[i].find("camera")) stage.shots[i].camera = stage.camera;
  const double size =
      2 * std::tan(camera.field_of_view / 2) * (camera.position - camera.target).norm();
  find_looks(document, scene, size);
  give_boxes(scene);
  if (written && written->find("scenery")) return left_out;
  const double floor = floor_of(scene, points, size);
  stage.scenery.push_back(cove_at(floor, camera));
  for (ConnectorLook& look : stage.connector_looks) look.knob = kPin * look.diameter;
  const double highest = std::ranges::max(points, {}, [](const Vec3& p) { return p.y(); }).y();
  const auto pins = pins_of(scene, camera, floor, highest, size);
  if (pins.size() <= kMostPins) stage.scenery.insert(stage.scenery.end(), pins.begin(), pins.end());
  return left_out;
}

}  // namespace taut::scenes
