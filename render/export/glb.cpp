// Scenes as animated binary glTF 2.0.
#include <fmt/format.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "render/export/frame_writer.h"
#include "render/mesh/connector_mesh.h"
#include "scenes/character/skeleton.h"
#include "scenes/format/document.h"
#include "scenes/model/model.h"
#include "scenes/scene/scene.h"
#include "scenes/scene/stage.h"
#include "sim/motion/types.h"

namespace taut::exporting {
namespace {

// A binary glTF file in the making: JSON, and the numbers that it speaks of.

class GltfFile {
 public:
  using Json = nlohmann::ordered_json;

  /// The numbers of components, as glTF 2.0, section 3.6.2.2 has them.
  enum Component : int { u8 = 5121, i16 = 5122, u16 = 5123, u32 = 5125, f32 = 5126 };
  enum class Use { animation, vertices, indices };

  /// Adds an object to one of the file's lists; its index there.
  std::size_t add(const char* list, Json object);
  Json& object(const char* list, std::size_t index) { return root_[list][index]; }

  struct Numbers {
    Component component;
    const char* type;  // as in "VEC3"
    Use use = Use::animation;
    bool normalized = false;
    bool bounds = false;  // whether the file says their least and largest, floats alone
  };
  /// Adds an accessor of all these numbers; its index. The items are as many bytes apart as they
  /// have.
  template <typename Number>
  std::size_t add_numbers(std::span<const Number> numbers, const Numbers& about) {
    const Json bounds = about.bounds ? bounds_of(numbers, about.type) : Json();
    return add_bytes({reinterpret_cast<const char*>(numbers.data()), numbers.size_bytes()},
                     sizeof(Number), about, bounds);
  }

  void name_scene(const std::string& name) { root_["scenes"][0]["name"] = name; }
  void use_extension(const char* name, Json said) {
    root_["extensionsUsed"].push_back(name);
    Json& extensions = root_["extensions"];
    if (extensions.is_null()) extensions = Json::object();
    extensions[name] = std::move(said);
  }

  /// The node's index. Without a parent it is a root of the scene.
  std::size_t add_node(const std::string& name, std::optional<std::size_t> parent = {});
  Json& node(std::size_t index) { return root_["nodes"][index]; }
  /// Places a node that does not move.
  void place(std::size_t node, const Pose& pose);

  /// Writes all of it. Nothing can be added then.
  void write(const WriteBytes& write);

 private:
  static Json& list_in(Json& object, const char* name);
  template <typename Number>
  static Json bounds_of(std::span<const Number> numbers, std::string_view type);
  std::size_t add_bytes(std::string_view bytes, std::size_t component_size, const Numbers& about,
                        const Json& bounds);

  Json root_ = {{"asset", {{"version", "2.0"}, {"generator", "taut"}}},
                {"extensionsUsed", Json::array()},
                {"scene", 0},
                {"scenes", {{{"nodes", Json::array()}}}}};
  std::string bytes_;
};

/// How many numbers an item of that type has.
std::size_t components_of(std::string_view type);

template <typename Number>
GltfFile::Json GltfFile::bounds_of(std::span<const Number> numbers, std::string_view type) {
  const std::size_t size = components_of(type);
  std::vector<Number> least(numbers.begin(), numbers.begin() + std::ptrdiff_t(size)),
      largest = least;
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    least[i % size] = std::min(least[i % size], numbers[i]);
    largest[i % size] = std::max(largest[i % size], numbers[i]);
  }
  return {{"min", least}, {"max", largest}};
}

constexpr std::uint32_t kMagic = 0x46546c67, kJsonChunk = 0x4e4f534a, kBinaryChunk = 0x004e4942;

void pad(std::string& bytes, char with) {
  bytes.append((4 - bytes.size() % 4) % 4, with);
}

std::size_t components_of(std::string_view type) {
  if (type == "SCALAR") return 1;
  if (type == "MAT4") return 16;
  return std::size_t(type.back() - '0');
}

/// The list of that name, which is made where there is none. A null that push_back() turns into a
/// list is left broken where memory runs out.
GltfFile::Json& GltfFile::list_in(Json& object, const char* name) {
  Json& list = object[name];
  if (list.is_null()) list = Json::array();
  return list;
}

std::size_t GltfFile::add(const char* list, Json object) {
  list_in(root_, list).push_back(std::move(object));
  return root_[list].size() - 1;
}

std::size_t GltfFile::add_bytes(std::string_view bytes, std::size_t component_size,
                                const Numbers& about, const Json& bounds) {
  pad(bytes_, 0);
  Json view = {{"buffer", 0}, {"byteOffset", bytes_.size()}, {"byteLength", bytes.size()}};
  if (about.use != Use::animation) view["target"] = about.use == Use::vertices ? 34962 : 34963;
  bytes_ += bytes;
  Json accessor = {{"bufferView", add("bufferViews", std::move(view))},
                   {"componentType", int(about.component)},
                   {"count", bytes.size() / component_size / components_of(about.type)},
                   {"type", about.type}};
  if (about.normalized) accessor["normalized"] = true;
  if (!bounds.is_null()) accessor.update(bounds);
  return add("accessors", std::move(accessor));
}

std::size_t GltfFile::add_node(const std::string& name, std::optional<std::size_t> parent) {
  const std::size_t index = add("nodes", {{"name", name}});
  if (parent) {
    list_in(node(*parent), "children").push_back(index);
  } else {
    root_["scenes"][0]["nodes"].push_back(index);
  }
  return index;
}

void GltfFile::place(std::size_t index, const Pose& pose) {
  const Quat q = pose.rotation.normalized();
  const Vec3& p = pose.position;
  if (!p.isZero(0)) node(index)["translation"] = {float(p.x()), float(p.y()), float(p.z())};
  if (q.w() < 1) node(index)["rotation"] = {float(q.x()), float(q.y()), float(q.z()), float(q.w())};
}

void GltfFile::write(const WriteBytes& write) {
  pad(bytes_, 0);
  if (!bytes_.empty()) root_["buffers"] = {{{"byteLength", bytes_.size()}}};
  if (root_["extensionsUsed"].empty()) root_.erase("extensionsUsed");
  std::string json = root_.dump();
  pad(json, ' ');
  const auto size = [](const std::string& chunk) { return std::uint32_t(chunk.size()); };
  write(little_endian(kMagic, std::uint32_t(2),
                      std::uint32_t(12 + 8 + size(json) + 8 + size(bytes_)), size(json),
                      kJsonChunk) +
        json + little_endian(size(bytes_), kBinaryChunk));
  write(bytes_);
}

// Meshes of models and connectors as glTF has them.

class GltfMeshes {
 public:
  explicit GltfMeshes(GltfFile& file) : file_(file) {}

  /// The mesh of a model, one primitive for each of its materials; made once. A vertex that no bone
  /// moves belongs to the joint behind the last bone; none where nothing is skinned.
  std::size_t of_model(const scenes::Model& model);
  /// True where some vertices of a skinned model have no bone.
  static bool has_fixed_vertices(const scenes::Model& model);

  /// One primitive, `joints` and `weights` empty where nothing is skinned.
  std::size_t of_mesh(const std::string& name, const scenes::Mesh& mesh,
                      const scenes::Material& material, bool skinned);

 private:
  GltfFile::Json primitive(const scenes::Mesh& mesh, const scenes::Material& material, bool skinned,
                           std::size_t fixed_joint);
  std::size_t material(const scenes::Material& material, const std::array<float, 3>& tint);

  GltfFile& file_;
  std::map<const scenes::Model*, std::size_t> models_;
  std::map<std::string, std::size_t> materials_;  // by what they say
};

using Json = GltfFile::Json;
using Use = GltfFile::Use;

constexpr std::uint16_t kWhole = 65535;

/// A vertex's bones, each once, and their weights, which add up to kWhole.
struct Weights {
  std::array<std::uint16_t, 4> joints{};
  std::array<std::uint16_t, 4> shares{};

  Weights(const scenes::Vertex& vertex, std::size_t fixed_joint) {
    double sum = 0;
    for (const float weight : vertex.weights) sum += weight;
    if (sum == 0) {
      joints[0] = std::uint16_t(fixed_joint);
      shares[0] = kWhole;
      return;
    }
    std::size_t used = 0;
    std::array<double, 4> exact{};
    for (std::size_t k = 0; k < 4; ++k) {
      if (vertex.weights[k] == 0) continue;
      const auto end = joints.begin() + std::ptrdiff_t(used);
      const auto same = std::find(joints.begin(), end, vertex.bones[k]);
      const auto slot = std::size_t(same - joints.begin());
      joints[slot] = vertex.bones[k];
      exact[slot] += kWhole * (vertex.weights[k] / sum);
      used = std::max(used, slot + 1);
    }
    // The largest takes what is left over by rounding.
    int left = kWhole;
    for (std::size_t k = 0; k < 4; ++k) {
      shares[k] = std::uint16_t(std::lround(exact[k]));
      left -= shares[k];
    }
    auto& largest = *std::ranges::max_element(shares);
    largest = std::uint16_t(largest + left);
  }
};

std::size_t GltfMeshes::of_model(const scenes::Model& model) {
  const auto [place, is_new] = models_.try_emplace(&model, 0);
  if (!is_new) return place->second;
  Json primitives = Json::array();
  for (const scenes::Mesh& mesh : model.meshes)
    if (!mesh.indices.empty())
      primitives.push_back(primitive(mesh, model.materials[mesh.material], !model.bones.empty(),
                                     model.bones.size()));
  place->second =
      file_.add("meshes", {{"name", model.name}, {"primitives", std::move(primitives)}});
  return place->second;
}

bool GltfMeshes::has_fixed_vertices(const scenes::Model& model) {
  for (const scenes::Mesh& mesh : model.meshes)
    for (const scenes::Vertex& v : mesh.vertices)
      if (v.weights[0] + v.weights[1] + v.weights[2] + v.weights[3] == 0) return true;
  return false;
}

std::size_t GltfMeshes::of_mesh(const std::string& name, const scenes::Mesh& mesh,
                                const scenes::Material& with, bool skinned) {
  return file_.add("meshes", {{"name", name}, {"primitives", {primitive(mesh, with, skinned, 0)}}});
}

Json GltfMeshes::primitive(const scenes::Mesh& mesh, const scenes::Material& with, bool skinned,
                           std::size_t fixed_joint) {
  // Colours of eight bits are shares of the brightest, which the material has.
  std::array<float, 3> tint{};
  for (const scenes::Vertex& v : mesh.vertices)
    for (std::size_t k = 0; k < 3; ++k) tint[k] = std::max(tint[k], v.color[k]);
  std::vector<float> positions, normals;
  std::vector<std::uint8_t> colors;
  std::vector<std::uint16_t> joints, weights;
  bool tinted = false;
  for (const scenes::Vertex& v : mesh.vertices) {
    positions.insert(positions.end(), v.position.begin(), v.position.end());
    const Vec3 normal(v.normal[0], v.normal[1], v.normal[2]);
    const Vec3 unit = normal.norm() > 0 ? Vec3(normal.normalized()) : Vec3::UnitY();
    for (const double number : unit) normals.push_back(float(number));
    for (std::size_t k = 0; k < 3; ++k) {
      const float share = tint[k] > 0 ? std::max(v.color[k], 0.0f) / tint[k] : 1;
      colors.push_back(std::uint8_t(std::lround(share * 255)));
      tinted |= colors.back() != 255;
    }
    colors.push_back(255);
    if (!skinned) continue;
    const Weights own(v, fixed_joint);
    joints.insert(joints.end(), own.joints.begin(), own.joints.end());
    weights.insert(weights.end(), own.shares.begin(), own.shares.end());
  }
  const auto add = [&](const auto& numbers, GltfFile::Numbers about) {
    return file_.add_numbers(std::span(numbers), about);
  };
  Json attributes = {
      {"POSITION", add(positions, {GltfFile::f32, "VEC3", Use::vertices, false, true})},
      {"NORMAL", add(normals, {GltfFile::f32, "VEC3", Use::vertices})}};
  if (tinted) attributes["COLOR_0"] = add(colors, {GltfFile::u8, "VEC4", Use::vertices, true});
  if (skinned) {
    if (std::ranges::all_of(joints, [](std::uint16_t joint) { return joint < 256; })) {
      const std::vector<std::uint8_t> small(joints.begin(), joints.end());
      attributes["JOINTS_0"] = add(small, {GltfFile::u8, "VEC4", Use::vertices});
    } else {
      attributes["JOINTS_0"] = add(joints, {GltfFile::u16, "VEC4", Use::vertices});
    }
    attributes["WEIGHTS_0"] = add(weights, {GltfFile::u16, "VEC4", Use::vertices, true});
  }
  std::size_t indices = 0;
  if (mesh.vertices.size() <= 65535) {
    const std::vector<std::uint16_t> small(mesh.indices.begin(), mesh.indices.end());
    indices = add(small, {GltfFile::u16, "SCALAR", Use::indices});
  } else {
    indices = add(mesh.indices, {GltfFile::u32, "SCALAR", Use::indices});
  }
  return {{"attributes", std::move(attributes)},
          {"indices", indices},
          {"material", material(with, tint)}};
}

std::size_t GltfMeshes::material(const scenes::Material& with, const std::array<float, 3>& tint) {
  Json color = Json::array();
  for (std::size_t k = 0; k < 3; ++k)
    color.push_back(std::clamp(with.base_color[k] * tint[k], 0.0f, 1.0f));
  color.push_back(1);
  const Json said = {{"name", with.name},
                     {"pbrMetallicRoughness",
                      {{"baseColorFactor", std::move(color)},
                       {"metallicFactor", std::clamp(with.metallic, 0.0f, 1.0f)},
                       {"roughnessFactor", std::clamp(with.roughness, 0.0f, 1.0f)}}}};
  const auto [place, is_new] = materials_.try_emplace(said.dump(), 0);
  if (is_new) place->second = file_.add("materials", said);
  return place->second;
}

/// Vertices that move, at rest, as a mesh without bones.
scenes::Mesh plain_mesh(std::span<const mesh::MovingVertex> vertices,
                        std::span<const std::uint32_t> indices, const Eigen::Vector3f& color) {
  scenes::Mesh mesh;
  mesh.indices.assign(indices.begin(), indices.end());
  for (const mesh::MovingVertex& v : vertices)
    mesh.vertices.push_back({{v.position.x(), v.position.y(), v.position.z()},
                             {v.normal.x(), v.normal.y(), v.normal.z()},
                             {color.x(), color.y(), color.z()}});
  return mesh;
}

// The animation of a glTF file: channels over one list of keys, or over their own part of it.

// Motions between two keys as glTF's cubic splines, fitted to the states between them.

/// The slopes (per second) of a cubic from one key to the next: as it leaves the one and comes to
/// the other.
template <int kSize>
struct Slopes {
  using Value = Eigen::Matrix<double, kSize, 1>;
  Value leaving, arriving;
};

/// The weights of a cubic's key values and slopes at the share `u` of an interval of `span` s
/// (glTF 2.0, appendix C).
struct HermiteWeights {
  double first, leaving, arriving, last;
};
HermiteWeights hermite_weights(double u, double span);

/// The slopes with which a cubic from the first to the last value comes nearest to those between
/// (least squares). `times` rise. Where too few are between to tell, the straight line.
template <int kSize>
Slopes<kSize> fit_slopes(std::span<const double> times,
                         std::span<const Eigen::Matrix<double, kSize, 1>> values) {
  using Value = Eigen::Matrix<double, kSize, 1>;
  const double start = times.front(), span = times.back() - start;
  const Value line = (values.back() - values.front()) / span;
  // Unknowns: by how much the slopes differ from the line's. A little weight on that decides where
  // nothing else does.
  constexpr double kTowardsLine = 1e-6;
  const double towards = kTowardsLine * span * span;
  double a = towards, b = 0, d = towards;
  Value p = Value::Zero(), q = Value::Zero();
  for (std::size_t i = 1; i + 1 < times.size(); ++i) {
    const double u = (times[i] - start) / span;
    const HermiteWeights w = hermite_weights(u, span);
    const Value rest = values[i] - values.front() - u * span * line;
    a += w.leaving * w.leaving;
    b += w.leaving * w.arriving;
    d += w.arriving * w.arriving;
    p += w.leaving * rest;
    q += w.arriving * rest;
  }
  const double determinant = a * d - b * b;
  return {line + (d * p - b * q) / determinant, line + (a * q - b * p) / determinant};
}

/// The cubic's value at the share `u` of the interval.
template <int kSize>
Eigen::Matrix<double, kSize, 1> on_cubic(const Eigen::Matrix<double, kSize, 1>& first,
                                         const Eigen::Matrix<double, kSize, 1>& last,
                                         const Slopes<kSize>& slopes, double u, double span) {
  const HermiteWeights w = hermite_weights(u, span);
  return w.first * first + w.leaving * slopes.leaving + w.arriving * slopes.arriving +
         w.last * last;
}

// Moving points and frames as cubic splines over one list of keys.

/// Takes states in the order of their times and keeps as few of them as keys as bring the splines
/// near the others: every frame is one, and whatever the limit needs between.
class SplineTracks {
 public:
  struct State {
    double time = 0;  // s
    std::vector<Vec3> points;
    std::vector<Pose> frames;
  };
  static constexpr double kLimit = 5e-5;  // m, by which splines may be off the states given

  /// `radii` tell of each frame how far from its origin there is something to see, m.
  SplineTracks(std::size_t points, std::vector<double> radii);

  /// Calls `key` with the index of each state that becomes one, counted from the first ever added.
  void add(State state, bool is_frame, const std::function<void(std::size_t)>& key);

  const std::vector<float>& times() const { return times_; }
  /// For every key: the slope before it, its value and the slope behind it, as glTF wants them.
  const std::vector<float>& point(std::size_t i) const { return points_[i]; }
  const std::vector<float>& position(std::size_t frame) const { return positions_[frame]; }
  /// Quaternions x, y, z, w.
  const std::vector<float>& rotation(std::size_t frame) const { return rotations_[frame]; }

  /// The largest distance of a point from its states, and of what is to see of a frame, m.
  double point_error() const { return point_error_; }
  double frame_error() const { return frame_error_; }

 private:
  using Vec4 = Eigen::Vector4d;
  struct Span;
  Span fit(std::size_t from, std::size_t to) const;
  void divide(std::size_t from, std::size_t to, const std::function<void(std::size_t)>& key);
  void first_key();

  std::vector<double> radii_;
  std::vector<State> pending_;  // from the last frame on
  std::size_t before_ = 0;      // states before these
  std::vector<float> times_;
  std::vector<std::vector<float>> points_, positions_, rotations_;
  double point_error_ = 0, frame_error_ = 0;
};

class GltfMotion {
 public:
  explicit GltfMotion(GltfFile& file) : file_(file) {}

  /// The node's own place is that of a joint as its mesh was made, and stays in the file.
  void keep(std::size_t node) { joints_.insert(node); }

  /// Where a node is at the next key, against its parent; straight between keys. Of each node at
  /// every key or never. Rotations are kept in 16 bits a number, to 6e-5 rad.
  void translate(std::size_t node, const Vec3& to);
  void turn(std::size_t node, const Quat& to);

  /// The same for all keys at once as cubic splines: slope before, value, slope behind.
  void spline_translation(std::size_t node, const std::vector<float>& numbers);
  void spline_rotation(std::size_t node, const std::vector<float>& numbers);

  /// Adds the animation to the file. A constant value becomes its node's place instead, unless that
  /// is kept. Nothing can be added then.
  void finish(const std::string& name, const std::vector<float>& times);

 private:
  void spline(std::size_t node, const char* path, std::size_t size,
              const std::vector<float>& numbers);
  /// A track of so many components an item, over the keys that it needs to be off by `most` at
  /// most, where that takes less room.
  template <typename Number>
  void straight(std::size_t node, const char* path, const GltfFile::Numbers& about,
                std::size_t size, double most, const std::vector<Number>& track,
                const std::vector<float>& times);
  /// A track of one key.
  template <typename Number>
  void still(std::size_t node, const char* path, const GltfFile::Numbers& about,
             std::span<const Number> value);
  std::size_t input(const std::vector<float>& times);
  void channel(std::size_t node, const char* path, const char* interpolation, std::size_t output);

  struct Spline {
    std::size_t node;
    const char* path;
    std::vector<float> numbers;
  };
  GltfFile& file_;
  std::map<std::size_t, std::vector<float>> translations_;
  std::map<std::size_t, std::vector<std::int16_t>> rotations_;
  std::set<std::size_t> joints_;      // whose places are kept
  std::optional<std::size_t> start_;  // the accessor of a list of one key
  GltfFile::Json channels_ = GltfFile::Json::array(), samplers_ = GltfFile::Json::array();
};

HermiteWeights hermite_weights(double u, double span) {
  const double v = 1 - u;
  return {v * v * (1 + 2 * u), span * u * v * v, -span * u * u * v, u * u * (3 - 2 * u)};
}

using Vec4 = Eigen::Vector4d;

/// A key without slopes, behind those that there are.
template <typename Value>
void add_key(std::vector<float>& track, const Value& value) {
  for (int k = 0; k < 3; ++k)
    for (const double number : value) track.push_back(k == 1 ? float(number) : 0.0f);
}

template <int kSize>
void add_span(std::vector<float>& track, const Slopes<kSize>& slopes,
              const Eigen::Matrix<double, kSize, 1>& last) {
  float* const leaving = track.data() + track.size() - kSize;
  for (int k = 0; k < kSize; ++k) leaving[k] = float(slopes.leaving[k]);
  add_key(track, last);
  float* const arriving = track.data() + track.size() - 3 * kSize;
  for (int k = 0; k < kSize; ++k) arriving[k] = float(slopes.arriving[k]);
}

/// The splines from one state to another, and how near they come to those between.
struct SplineTracks::Span {
  std::vector<Slopes<3>> points, positions;
  std::vector<Slopes<4>> rotations;
  double point_error = 0, frame_error = 0;
  std::size_t worst = 0;  // the state that is off most
};

SplineTracks::SplineTracks(std::size_t points, std::vector<double> radii)
    : radii_(std::move(radii)),
      points_(points),
      positions_(radii_.size()),
      rotations_(radii_.size()) {}

void SplineTracks::add(State state, bool is_frame, const std::function<void(std::size_t)>& key) {
  // q and -q are one rotation: of the two, the one that is near the state before.
  for (std::size_t i = 0; !pending_.empty() && i < state.frames.size(); ++i) {
    Quat& q = state.frames[i].rotation;
    if (q.dot(pending_.back().frames[i].rotation) < 0) q.coeffs() *= -1;
  }
  pending_.push_back(std::move(state));
  if (times_.empty()) {
    first_key();
    key(0);
  } else if (is_frame) {
    divide(0, pending_.size() - 1, key);
    before_ += pending_.size() - 1;
    pending_.erase(pending_.begin(), pending_.end() - 1);
  }
}

void SplineTracks::first_key() {
  const State& state = pending_.front();
  times_.push_back(float(state.time));
  for (std::size_t i = 0; i < points_.size(); ++i) add_key(points_[i], state.points[i]);
  for (std::size_t i = 0; i < radii_.size(); ++i) {
    add_key(positions_[i], state.frames[i].position);
    add_key(rotations_[i], state.frames[i].rotation.coeffs());
  }
}

SplineTracks::Span SplineTracks::fit(std::size_t from, std::size_t to) const {
  Span span;
  const std::size_t count = to - from + 1;
  std::vector<double> times;
  for (std::size_t i = from; i <= to; ++i) times.push_back(pending_[i].time);
  const double length = times.back() - times.front();
  double largest = 0;
  std::vector<Vec3> points(count);
  std::vector<Vec4> turns(count);
  const auto off = [&](std::size_t i, double distance, double& error) {
    error = std::max(error, distance);
    if (distance > largest) {
      largest = distance;
      span.worst = from + i;
    }
  };
  const auto follow = [&](double& error) {
    const Slopes<3> slopes = fit_slopes<3>(times, points);
    for (std::size_t i = 1; i + 1 < count; ++i) {
      const double u = (times[i] - times.front()) / length;
      off(i, (on_cubic<3>(points.front(), points.back(), slopes, u, length) - points[i]).norm(),
          error);
    }
    return slopes;
  };
  for (std::size_t p = 0; p < points_.size(); ++p) {
    for (std::size_t i = 0; i < count; ++i) points[i] = pending_[from + i].points[p];
    span.points.push_back(follow(span.point_error));
  }
  for (std::size_t f = 0; f < radii_.size(); ++f) {
    for (std::size_t i = 0; i < count; ++i) {
      points[i] = pending_[from + i].frames[f].position;
      turns[i] = pending_[from + i].frames[f].rotation.coeffs();
    }
    span.positions.push_back(follow(span.frame_error));
    const Slopes<4> slopes = fit_slopes<4>(times, turns);
    for (std::size_t i = 1; i + 1 < count; ++i) {
      const double u = (times[i] - times.front()) / length;
      const Vec4 turn = on_cubic<4>(turns.front(), turns.back(), slopes, u, length).normalized();
      off(i, 2 * (turn - turns[i]).norm() * radii_[f], span.frame_error);
    }
    span.rotations.push_back(slopes);
  }
  return span;
}

void SplineTracks::divide(std::size_t from, std::size_t to,
                          const std::function<void(std::size_t)>& key) {
  const Span span = fit(from, to);
  if (std::max(span.point_error, span.frame_error) > kLimit) {
    divide(from, span.worst, key);
    return divide(span.worst, to, key);
  }
  point_error_ = std::max(point_error_, span.point_error);
  frame_error_ = std::max(frame_error_, span.frame_error);
  const State& state = pending_[to];
  times_.push_back(float(state.time));
  for (std::size_t i = 0; i < points_.size(); ++i)
    add_span<3>(points_[i], span.points[i], state.points[i]);
  for (std::size_t i = 0; i < radii_.size(); ++i) {
    add_span<3>(positions_[i], span.positions[i], state.frames[i].position);
    add_span<4>(rotations_[i], span.rotations[i], state.frames[i].rotation.coeffs());
  }
  key(before_ + to);
}

/// True where no component, of so many an item, changes by more than `most`.
template <typename Number>
bool stands(const std::vector<Number>& numbers, std::size_t size, double most) {
  for (std::size_t k = 0; k < size; ++k) {
    Number least = numbers[k], largest = numbers[k];
    for (std::size_t i = k; i < numbers.size(); i += size) {
      least = std::min(least, numbers[i]);
      largest = std::max(largest, numbers[i]);
    }
    if (double(largest) - double(least) > most) return false;
  }
  return true;
}

constexpr double kOne = 32767;  // of 16 bits

/// The keys of a track without those that are off the straight way between their neighbours by
/// `most` at most, in none of so many components an item.
template <typename Number>
std::vector<std::size_t> needed_keys(const std::vector<Number>& track, std::size_t size,
                                     double most, const std::vector<float>& times) {
  constexpr std::size_t kLongest = 128;  // keys from one to the next
  const auto straight = [&](std::size_t from, std::size_t to) {
    for (std::size_t i = from + 1; i < to; ++i) {
      const double share = double(times[i] - times[from]) / double(times[to] - times[from]);
      for (std::size_t k = 0; k < size; ++k) {
        const double on_line =
            std::lerp(double(track[size * from + k]), double(track[size * to + k]), share);
        if (std::abs(on_line - double(track[size * i + k])) > most) return false;
      }
    }
    return true;
  };
  std::vector<std::size_t> keys{0};
  while (keys.back() + 1 < times.size()) {
    std::size_t next = keys.back() + 1;
    const std::size_t last = std::min(times.size() - 1, keys.back() + kLongest);
    while (next < last && straight(keys.back(), next + 1)) ++next;
    keys.push_back(next);
  }
  return keys;
}

void GltfMotion::translate(std::size_t node, const Vec3& to) {
  for (const double number : to) translations_[node].push_back(float(number));
}

void GltfMotion::turn(std::size_t node, const Quat& to) {
  std::vector<std::int16_t>& track = rotations_[node];
  Eigen::Vector4d q = to.normalized().coeffs();
  if (!track.empty()) {
    double dot = 0;
    for (std::size_t k = 0; k < 4; ++k) dot += double(track[track.size() - 4 + k]) * q[int(k)];
    if (dot < 0) q *= -1;
  }
  for (const double number : q) track.push_back(std::int16_t(std::lround(number * kOne)));
}

void GltfMotion::spline_translation(std::size_t node, const std::vector<float>& numbers) {
  spline(node, "translation", 3, numbers);
}

void GltfMotion::spline_rotation(std::size_t node, const std::vector<float>& numbers) {
  spline(node, "rotation", 4, numbers);
}

void GltfMotion::spline(std::size_t node, const char* path, std::size_t size,
                        const std::vector<float>& numbers) {
  if (stands(numbers, 3 * size, 0)) {
    const auto value = numbers.begin() + std::ptrdiff_t(size);
    const std::vector<float> one(value, value + std::ptrdiff_t(size));
    if (joints_.contains(node)) {
      still<float>(node, path, {GltfFile::f32, size == 3 ? "VEC3" : "VEC4"}, one);
    } else {
      file_.node(node)[path] = one;
    }
    return;
  }
  channel(node, path, "CUBICSPLINE",
          file_.add_numbers(std::span(numbers), {GltfFile::f32, size == 3 ? "VEC3" : "VEC4"}));
}

void GltfMotion::channel(std::size_t node, const char* path, const char* interpolation,
                         std::size_t output) {
  channels_.push_back(
      {{"sampler", samplers_.size()}, {"target", {{"node", node}, {"path", path}}}});
  samplers_.push_back({{"input", nullptr}, {"interpolation", interpolation}, {"output", output}});
}

std::size_t GltfMotion::input(const std::vector<float>& times) {
  return file_.add_numbers(std::span(times),
                           {GltfFile::f32, "SCALAR", GltfFile::Use::animation, false, true});
}

template <typename Number>
void GltfMotion::straight(std::size_t node, const char* path, const GltfFile::Numbers& about,
                          std::size_t size, double most, const std::vector<Number>& track,
                          const std::vector<float>& times) {
  const auto add = [&](const std::vector<Number>& numbers) {
    channel(node, path, "LINEAR", file_.add_numbers(std::span<const Number>(numbers), about));
  };
  const std::vector<std::size_t> keys = needed_keys(track, size, most, times);
  const std::size_t value_bytes = size * sizeof(Number);
  if (keys.size() * (value_bytes + sizeof(float)) >= times.size() * value_bytes) return add(track);
  std::vector<float> own;
  std::vector<Number> values;
  for (const std::size_t key : keys) {
    own.push_back(times[key]);
    const auto value = track.begin() + std::ptrdiff_t(size * key);
    values.insert(values.end(), value, value + std::ptrdiff_t(size));
  }
  add(values);
  samplers_.back()["input"] = input(own);
}

template <typename Number>
void GltfMotion::still(std::size_t node, const char* path, const GltfFile::Numbers& about,
                       std::span<const Number> value) {
  channel(node, path, "STEP", file_.add_numbers(value, about));
  if (!start_) start_ = input({0});
  samplers_.back()["input"] = *start_;
}

void GltfMotion::finish(const std::string& name, const std::vector<float>& times) {
  for (const auto& [node, numbers] : translations_) {
    constexpr double kStill = 1e-7, kOff = 2e-5;  // m
    const GltfFile::Numbers about{GltfFile::f32, "VEC3"};
    if (!stands(numbers, 3, kStill)) {
      straight(node, "translation", about, 3, kOff, numbers, times);
    } else if (joints_.contains(node)) {
      still(node, "translation", about, std::span<const float>(numbers).first(3));
    } else {
      file_.place(node, {Vec3(numbers[0], numbers[1], numbers[2]), Quat::Identity()});
    }
  }
  for (const auto& [node, numbers] : rotations_) {
    constexpr double kSteps = 2;  // of 16 bits: 6e-5 rad
    const GltfFile::Numbers about{GltfFile::i16, "VEC4", GltfFile::Use::animation, true};
    if (!stands(numbers, 4, kSteps)) {
      straight(node, "rotation", about, 4, kSteps, numbers, times);
    } else if (joints_.contains(node)) {
      still(node, "rotation", about, std::span<const std::int16_t>(numbers).first(4));
    } else {
      file_.place(node, {Vec3::Zero(), Quat(numbers[3], numbers[0], numbers[1], numbers[2])});
    }
  }
  if (channels_.empty()) return;
  const std::size_t all = input(times);
  for (GltfFile::Json& sampler : samplers_)
    if (sampler["input"].is_null()) sampler["input"] = all;
  file_.add(
      "animations",
      {{"name", name}, {"channels", std::move(channels_)}, {"samplers", std::move(samplers_)}});
}

// A connector as nodes of a glTF file: one for each particle, and what is seen of it.

class GltfConnector {
 public:
  /// A chain's links hang on the particles at which they begin; the tube of a rope or cord is
  /// skinned to its particles. `bodies` are the nodes of the bodies, `models` what these look like.
  GltfConnector(GltfFile& file, GltfMeshes& meshes, const Connector& connector,
                const scenes::ConnectorLook& look, std::span<const std::size_t> bodies,
                std::span<const std::shared_ptr<const scenes::Model>> models);

  /// The nodes of the particles, for whoever moves them.
  const std::vector<std::size_t>& particles() const { return particles_; }

  /// Those of them that are joints of a tube: their own places are those of its mesh as it is made.
  std::span<const std::size_t> joints() const {
    return links_.empty() ? std::span<const std::size_t>(particles_)
                          : std::span<const std::size_t>();
  }

  /// Turns particles or links as they are at the next key.
  void turn(std::span<const Vec3> particles, std::span<const Pose> bodies, GltfMotion& motion);

 private:
  struct Link {
    std::size_t node, particle;  // the particle at or before its beginning
    bool off;                    // it begins behind that
  };
  void add_chain(GltfFile& file, GltfMeshes& meshes, const Connector& connector,
                 const scenes::ConnectorLook& look, std::span<const std::size_t> bodies,
                 std::span<const std::shared_ptr<const scenes::Model>> models);
  void add_tube(GltfFile& file, GltfMeshes& meshes, const Connector& connector,
                const scenes::ConnectorLook& look);
  void turn_links(std::span<const Vec3> particles, std::span<const Pose> bodies,
                  GltfMotion& motion) const;
  void turn_particles(std::span<const Vec3> particles, GltfMotion& motion);

  std::vector<std::size_t> particles_;
  std::vector<Link> links_;  // empty: a tube
  std::array<std::optional<mesh::ChainMount>, 2> mounts_;
  Vec3 axis_ = Vec3::UnitY(), side_ = Vec3::UnitX();  // of the tube's beginning at the last key
};

Quat frame_of(const Vec3& x, const Vec3& y) {
  Mat3 axes;
  axes << x, y, x.cross(y);
  return Quat(axes);
}

scenes::Material material_of(const scenes::ConnectorLook& look) {
  const bool chain = look.kind == scenes::ConnectorLook::Kind::chain;
  return {.name = chain ? "steel" : "rope",
          .base_color = {1, 1, 1},
          .roughness = chain ? 0.25f : 0.9f,
          .metallic = chain ? 1.0f : 0.0f};
}

GltfConnector::GltfConnector(GltfFile& file, GltfMeshes& meshes, const Connector& connector,
                             const scenes::ConnectorLook& look, std::span<const std::size_t> bodies,
                             std::span<const std::shared_ptr<const scenes::Model>> models) {
  const std::size_t group = file.add_node(connector.name);
  for (std::size_t i = 0; i < connector.particles(); ++i) {
    particles_.push_back(file.add_node(connector.name + '.' + std::to_string(i), group));
    file.node(particles_.back())["extras"] = {{"particle", i}};
  }
  if (look.kind == scenes::ConnectorLook::Kind::chain) {
    add_chain(file, meshes, connector, look, bodies, models);
  } else {
    add_tube(file, meshes, connector, look);
  }
}

void GltfConnector::add_chain(GltfFile& file, GltfMeshes& meshes, const Connector& connector,
                              const scenes::ConnectorLook& look,
                              std::span<const std::size_t> bodies,
                              std::span<const std::shared_ptr<const scenes::Model>> models) {
  const mesh::ChainShape shape = mesh::chain_shape(connector.length, look.diameter);
  const scenes::Material steel = material_of(look);
  const auto mesh_of = [&](const char* what, mesh::Piece piece, double up) {
    for (mesh::MovingVertex& v : piece.vertices) v.position.y() += float(up);
    return meshes.of_mesh(connector.name + ' ' + what,
                          plain_mesh(piece.vertices, piece.indices, look.color.cast<float>()),
                          steel, false);
  };
  const std::size_t link_mesh = mesh_of("link", shape.link, shape.pitch / 2);
  const double spans = double(connector.particles() - 1);
  for (std::size_t k = 0; k < shape.links; ++k) {
    const double at = double(k) / double(shape.links) * spans;
    const auto particle = std::min(std::size_t(at + 1e-9), connector.particles() - 2);
    const std::size_t node =
        file.add_node(connector.name + " link " + std::to_string(k), particles_[particle]);
    file.node(node)["mesh"] = link_mesh;
    links_.push_back({node, particle, at - double(particle) > 1e-9});
  }
  std::optional<std::size_t> ring, collar;
  for (const bool last : {false, true}) {
    auto& mount = mounts_[last];
    mount = mesh::chain_mount(connector, last ? connector.particles() - 1 : 0, models);
    if (!mount) continue;
    if (!ring) {
      ring = mesh_of("eye", shape.ring, 0);
      collar = mesh_of("collar", shape.collar, 0);
    }
    // The eye hangs in the link, at right angles to it, beyond its end.
    const Link& link = last ? links_.back() : links_.front();
    const std::size_t eye = file.add_node(connector.name + " eye", link.node);
    file.node(eye)["mesh"] = *ring;
    const double out = last ? 1 : -1;
    file.place(eye, {Vec3(0, (last ? shape.pitch : 0) + out * shape.inset, 0),
                     frame_of(Vec3(0, 0, -out), Vec3(0, -out, 0))});
    const std::size_t on_body = file.add_node(connector.name + " collar", bodies[mount->body]);
    file.node(on_body)["mesh"] = *collar;
    const std::size_t particle = last ? connector.particles() - 1 : 0;
    for (const Hold& hold : connector.holds)
      if (hold.particle == particle)
        file.place(on_body, {hold.to.point, frame_of(mount->axis.unitOrthogonal(), mount->axis)});
  }
}

void GltfConnector::add_tube(GltfFile& file, GltfMeshes& meshes, const Connector& connector,
                             const scenes::ConnectorLook& look) {
  // The rest pose is straight along y.
  std::vector<Vec3> straight{Vec3::Zero()};
  for (const double rest : connector.rest)
    straight.push_back(straight.back() + rest * Vec3::UnitY());
  const auto shape = mesh::make_connector_mesh(connector, look, {});
  std::vector<mesh::MovingVertex> vertices;
  shape->place(straight, {}, vertices);
  scenes::Mesh mesh = plain_mesh(vertices, shape->indices(), Eigen::Vector3f::Ones());
  const double radius = look.diameter / 2, length = straight.back().y();
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    scenes::Vertex& v = mesh.vertices[i];
    const Eigen::Vector3f& color = shape->rest()[i].color;
    v.color = {color.x(), color.y(), color.z()};
    const double y = v.position[1];
    const auto above =
        std::ranges::upper_bound(straight, y, {}, [](const Vec3& p) { return p.y(); });
    const auto next = std::clamp<std::ptrdiff_t>(above - straight.begin(), 1,
                                                 std::ptrdiff_t(straight.size()) - 1);
    const double low = straight[std::size_t(next - 1)].y(), high = straight[std::size_t(next)].y();
    const double share = high > low ? std::clamp((y - low) / (high - low), 0.0, 1.0) : 0;
    const auto bone = [](auto number) { return std::uint16_t(number); };
    v.bones = {bone(next - 1), bone(next), 0, 0};
    v.weights = {float(1 - share), float(share), 0, 0};
    // A weight at an end moves as one.
    if (std::hypot(v.position[0], v.position[2]) > 1.01 * radius || y < 0 || y > length) {
      v.bones = {bone(y < length / 2 ? 0 : straight.size() - 1), 0, 0, 0};
      v.weights = {1, 0, 0, 0};
    }
  }
  // Joints are there as the mesh was made: Blender's rest pose is that of the nodes, and a mesh
  // that is collapsed there has its normals from nowhere.
  for (std::size_t i = 0; i < straight.size(); ++i)
    file.place(particles_[i], {straight[i], Quat::Identity()});
  std::vector<float> inverse_bind;
  for (const Vec3& p : straight) {
    const float m[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, -float(p.y()), 0, 1};
    inverse_bind.insert(inverse_bind.end(), std::begin(m), std::end(m));
  }
  const std::size_t skin = file.add(
      "skins", {{"inverseBindMatrices",
                 file.add_numbers(std::span<const float>(inverse_bind), {GltfFile::f32, "MAT4"})},
                {"joints", particles_}});
  const std::size_t node = file.add_node(connector.name + " tube");
  file.node(node)["mesh"] = meshes.of_mesh(connector.name, mesh, material_of(look), true);
  file.node(node)["skin"] = skin;
}

void GltfConnector::turn(std::span<const Vec3> particles, std::span<const Pose> bodies,
                         GltfMotion& motion) {
  if (links_.empty()) {
    turn_particles(particles, motion);
  } else {
    turn_links(particles, bodies, motion);
  }
}

void GltfConnector::turn_links(std::span<const Vec3> particles, std::span<const Pose> bodies,
                               GltfMotion& motion) const {
  const auto hold =
      [&](const std::optional<mesh::ChainMount>& mount) -> std::optional<mesh::ChainHold> {
    if (!mount) return {};
    const Quat& turn = bodies[mount->body].rotation;
    return mesh::ChainHold{turn * mount->axis, turn * mount->axis.unitOrthogonal()};
  };
  const std::vector<mesh::LinkFrame> frames =
      mesh::link_frames(particles, links_.size(), hold(mounts_[0]), hold(mounts_[1]));
  for (std::size_t k = 0; k < links_.size(); ++k) {
    motion.turn(links_[k].node, frame_of(frames[k].wide, frames[k].axis));
    if (links_[k].off)
      motion.translate(links_[k].node, frames[k].from - particles[links_[k].particle]);
  }
}

void GltfConnector::turn_particles(std::span<const Vec3> particles, GltfMotion& motion) {
  Vec3 axis = axis_, side = side_;
  for (std::size_t i = 0; i < particles.size(); ++i) {
    const Vec3 along =
        particles[std::min(i + 1, particles.size() - 1)] - particles[i > 0 ? i - 1 : 0];
    const double length = along.norm();
    const Vec3 next = length > 1e-12 ? Vec3(along / length) : axis;
    side = mesh::transport(side, axis, next);
    axis = next;
    motion.turn(particles_[i], frame_of(side, axis));
    if (i == 0) {
      axis_ = axis;
      side_ = side;
    }
  }
}

// Cameras and the key light of a stage as nodes of a glTF file.

class GltfView {
 public:
  GltfView(GltfFile& file, const scenes::Scene& scene);

  /// Places the cameras as they are at `time` (s), the next key.
  void place(double time, GltfMotion& motion) const;

 private:
  struct Camera {
    std::size_t node;
    NamedCamera camera;
  };
  std::vector<Camera> cameras_;
};

// A character as a skin and a skeleton of a glTF file.

class GltfFigure {
 public:
  GltfFigure(GltfFile& file, GltfMeshes& meshes, const std::string& name,
             const scenes::Model& model);

  /// Poses the skeleton as it is at the next key; poses in the world, one for each of the bones.
  void pose(std::span<const Pose> bones, GltfMotion& motion) const;

 private:
  const scenes::Model& model_;
  std::vector<std::size_t> bones_;  // nodes
};

class GlbWriter final : public FrameWriter {
 public:
  GlbWriter(const scenes::Scene& scene, WriteBytes write)
      : scene_(scene), write_(std::move(write)), world_(divided(scene.world, scene.timeline)) {
    file_.name_scene(scene.title);
    add_bodies();
    add_connectors();
    if (!scene.stage) return;
    const scenes::Stage& stage = *scene.stage;
    for (std::size_t i = 0; i < stage.characters.size(); ++i)
      figures_.emplace_back(
          file_, meshes_,
          stage.characters.size() == 1 ? "character" : fmt::format("character {}", i + 1),
          *stage.characters[i]);
    for (const auto& model : stage.scenery)
      file_.node(file_.add_node(model->name))["mesh"] = meshes_.of_model(*model);
    view_.emplace(file_, scene);
  }

  int states_per_frame() const override { return parts_of_frame(scene_); }

  void add(const ExportState& state) override {
    SplineTracks::State moved{state.state.time, {}, state.state.bodies};
    for (const auto& particles : state.state.connectors)
      moved.points.insert(moved.points.end(), particles.begin(), particles.end());
    states_.push_back(state.state);
    tracks_->add(std::move(moved), state.frame, [&](std::size_t key) {
      for (; dropped_ < key; ++dropped_) states_.pop_front();
      add_key(states_.front());
    });
  }

  void finish() override {
    std::size_t point = 0;
    for (const GltfConnector& connector : connectors_)
      for (const std::size_t node : connector.particles())
        motion_.spline_translation(node, tracks_->point(point++));
    for (std::size_t i = 0; i < bodies_.size(); ++i) {
      motion_.spline_translation(bodies_[i], tracks_->position(i));
      motion_.spline_rotation(bodies_[i], tracks_->rotation(i));
    }
    motion_.finish("motion", tracks_->times());
    file_.write(write_);
  }

  Figures figures() const override {
    return {{"keys", tracks_->times().size()},
            {"particles_between_frames_off_by_m", tracks_->point_error()},
            {"bodies_between_frames_off_by_m", tracks_->frame_error()}};
  }

 private:
  void add_bodies() {
    for (std::size_t i = 0; const auto& model : body_models(scene_)) {
      const Body& body = world_.bodies[i++];
      const std::size_t node = file_.add_node(body.name);
      file_.node(node)["extras"] = {{"mass_kg", body.mass_properties.mass}};
      if (model) file_.node(node)["mesh"] = meshes_.of_model(*model);
      bodies_.push_back(node);
    }
  }

  void add_connectors() {
    constexpr std::size_t kMostJoints = 65536;
    std::size_t points = 0;
    for (std::size_t i = 0; const Connector& connector : world_.connectors) {
      if (connector.particles() > kMostJoints)
        scenes::fail_at(scene_.file,
                        {"connectors", std::string(scenes::written_name(connector.name))},
                        fmt::format("{} has {} particles, expected at most {} for a glTF file",
                                    connector.name, connector.particles(), kMostJoints));
      connectors_.emplace_back(file_, meshes_, connector, look_of(scene_, i++), bodies_,
                               body_models(scene_));
      for (const std::size_t joint : connectors_.back().joints()) motion_.keep(joint);
      points += connector.particles();
    }
    tracks_.emplace(points, bounding_radii(scene_));
  }

  void add_key(const Snapshot& state) {
    for (std::size_t i = 0; i < connectors_.size(); ++i)
      connectors_[i].turn(state.connectors[i], state.bodies, motion_);
    for (std::size_t i = 0; i < figures_.size(); ++i)
      figures_[i].pose(scene_.performances[i]->bones_at(state.time), motion_);
    if (view_) view_->place(state.time, motion_);
  }

  const scenes::Scene& scene_;
  WriteBytes write_;
  World world_;
  GltfFile file_;
  GltfMeshes meshes_{file_};
  GltfMotion motion_{file_};
  std::vector<std::size_t> bodies_;  // nodes
  std::vector<GltfConnector> connectors_;
  std::vector<GltfFigure> figures_;
  std::optional<GltfView> view_;
  std::optional<SplineTracks> tracks_;
  std::deque<Snapshot> states_;  // since the last key
  std::size_t dropped_ = 0;      // before these
};

}  // namespace

std::unique_ptr<FrameWriter> glb_writer(const scenes::Scene& scene, WriteBytes write) {
  return std::make_unique<GlbWriter>(scene, std::move(write));
}

GltfView::GltfView(GltfFile& file, const scenes::Scene& scene) {
  for (const NamedCamera& camera : cameras(scene)) {
    const std::size_t lens =
        file.add("cameras", {{"name", camera.name},
                             {"type", "perspective"},
                             {"perspective",
                              {{"aspectRatio", double(scene.width) / scene.height},
                               {"yfov", scenes::camera_at(camera.keys, camera.start).field_of_view},
                               {"znear", 0.05},
                               {"zfar", 60}}}});
    const std::size_t node = file.add_node(camera.name);
    file.node(node)["camera"] = lens;
    cameras_.push_back({node, camera});
  }
  const scenes::Light& light = scene.stage->light;
  const double brightest = std::max(light.color.maxCoeff(), 1e-9);
  const Vec3 color = light.color / brightest;
  const char* const extension = "KHR_lights_punctual";
  const char* const name = "key light";
  file.use_extension(extension, {{"lights",
                                  {{{"name", name},
                                    {"type", "directional"},
                                    {"color", {color.x(), color.y(), color.z()}},
                                    {"intensity", brightest}}}}});
  const std::size_t node = file.add_node(name);
  file.node(node)["extensions"] = {{extension, {{"light", 0}}}};
  file.place(node, {Vec3::Zero(), looking(light.direction)});
}

void GltfView::place(double time, GltfMotion& motion) const {
  for (const auto& [node, camera] : cameras_) {
    const scenes::CameraView view = scenes::camera_at(camera.keys, time);
    motion.translate(node, view.position);
    motion.turn(node, looking(view.target - view.position));
  }
}

GltfFigure::GltfFigure(GltfFile& file, GltfMeshes& meshes, const std::string& name,
                       const scenes::Model& model)
    : model_(model) {
  const std::size_t group = file.add_node(name);
  for (const scenes::Bone& bone : model.bones)
    bones_.push_back(
        file.add_node(bone.name, bone.parent < 0 ? group : bones_[std::size_t(bone.parent)]));
  std::vector<std::size_t> joints = bones_;
  std::vector<float> inverse_bind;
  for (const scenes::Bone& bone : model.bones) {
    Eigen::Matrix4f m = bone.inverse_bind;
    m.row(3) << 0, 0, 0, 1;
    inverse_bind.insert(inverse_bind.end(), m.data(), m.data() + m.size());
  }
  if (GltfMeshes::has_fixed_vertices(model)) {
    joints.push_back(group);
    const Eigen::Matrix4f none = Eigen::Matrix4f::Identity();
    inverse_bind.insert(inverse_bind.end(), none.data(), none.data() + none.size());
  }
  const std::size_t skin = file.add(
      "skins", {{"name", name},
                {"inverseBindMatrices",
                 file.add_numbers(std::span<const float>(inverse_bind), {GltfFile::f32, "MAT4"})},
                {"skeleton", group},
                {"joints", joints}});
  const std::size_t node = file.add_node(name + " skin");
  file.node(node)["mesh"] = meshes.of_model(model);
  file.node(node)["skin"] = skin;
}

void GltfFigure::pose(std::span<const Pose> bones, GltfMotion& motion) const {
  for (std::size_t i = 0; i < bones_.size(); ++i) {
    const int parent = model_.bones[i].parent;
    const Pose above = parent < 0 ? Pose() : bones[std::size_t(parent)];
    const Quat back = above.rotation.conjugate();
    motion.translate(bones_[i], back * (bones[i].position - above.position));
    motion.turn(bones_[i], back * bones[i].rotation);
  }
}

}  // namespace taut::exporting
