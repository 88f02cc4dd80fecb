#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <set>

#include "render/export/frame_writer.h"

namespace taut::exporting {
namespace {

/// To a ten-millionth, without more digits than that needs.
double rounded(double number) {
  return std::round(number * 1e7) / 1e7 + 0.0;  // never -0
}

std::string text(const Vec3& v) {
  return fmt::format("({}, {}, {})", rounded(v.x()), rounded(v.y()), rounded(v.z()));
}

std::string text(const Quat& q) {
  return fmt::format("({}, {}, {}, {})", rounded(q.w()), rounded(q.x()), rounded(q.y()),
                     rounded(q.z()));
}

std::string text(const std::array<float, 3>& v) {
  return fmt::format("({}, {}, {})", v[0], v[1], v[2]);
}

template <typename Items>
std::string list(const Items& items) {
  std::string line = "[";
  for (const auto& item : items) line += (line.size() > 1 ? ", " : "") + text(item);
  return line + "]";
}

/// A quoted string.
std::string quoted(const std::string& words) {
  std::string line = "\"";
  for (const char c : words) {
    if (c == '"' || c == '\\') line += '\\';
    line += c == '\n' ? ' ' : c;
  }
  return line + '"';
}

/// Names of prims beside each other: letters, digits and underscores, each once.
class Names {
 public:
  std::string of(std::string name) {
    for (char& c : name)
      if (!std::isalnum(static_cast<unsigned char>(c))) c = '_';
    if (name.empty() || std::isdigit(static_cast<unsigned char>(name[0]))) name = '_' + name;
    std::string free = name;
    for (int i = 2; !used_.insert(free).second; ++i) free = fmt::format("{}_{}", name, i);
    return free;
  }

 private:
  std::set<std::string> used_;
};

/// Something that is moved as a whole.
struct Placed {
  std::string name;
  std::string translate = {}, orient = {};  // time samples
  Quat last = Quat::Identity();

  void add(double code, const Pose& pose) {
    Quat q = pose.rotation;
    if (q.dot(last) < 0) q.coeffs() *= -1;
    last = q;
    translate += fmt::format("      {}: {},\n", code, text(pose.position));
    orient += fmt::format("      {}: {},\n", code, text(q));
  }
  std::string samples() const {
    return fmt::format(
        "    double3 xformOp:translate.timeSamples = {{\n{}    }}\n"
        "    quatf xformOp:orient.timeSamples = {{\n{}    }}\n"
        "    uniform token[] xformOpOrder = [\"xformOp:translate\", \"xformOp:orient\"]\n",
        translate, orient);
  }
};

class UsdaWriter final : public FrameWriter {
 public:
  UsdaWriter(const scenes::Scene& scene, WriteBytes write)
      : scene_(scene),
        write_(std::move(write)),
        world_(divided(scene.world, scene.timeline)),
        keys_(bounding_radii(scene)) {
    for (const Connector& connector : world_.connectors)
      connectors_.push_back({names_.of(connector.name), ""});
    for (const Body& body : world_.bodies) bodies_.push_back({names_.of(body.name)});
    if (!scene.stage) return;
    for (const NamedCamera& camera : cameras(scene)) {
      views_.push_back(camera);
      cameras_.push_back({names_.of(camera.name)});
      lenses_.emplace_back();
      stops_.emplace_back();
      focuses_.emplace_back();
    }
  }

  int states_per_frame() const override { return parts_of_frame(scene_); }

  void add(const ExportState& state) override {
    keys_.add(state.state, state.frame, [this](const Snapshot& key) { add_key(key); });
  }

  void finish() override {
    write_(
        fmt::format("#usda 1.0\n(\n  defaultPrim = \"scene\"\n  doc = {}\n  startTimeCode = 0\n"
                    "  endTimeCode = {}\n  timeCodesPerSecond = {}\n  framesPerSecond = {}\n"
                    "  metersPerUnit = 1\n  upAxis = \"Y\"\n)\n\ndef Xform \"scene\"\n{{\n",
                    quoted(scene_.title), scene_.frames() - 1, scene_.fps, scene_.fps));
    for (std::size_t i = 0; i < connectors_.size(); ++i) write_connector(i);
    const auto models = body_models(scene_);
    for (std::size_t i = 0; i < bodies_.size(); ++i) {
      write_(fmt::format("  def Xform \"{}\"\n  {{\n{}", bodies_[i].name, bodies_[i].samples()));
      if (models[i]) write_meshes(*models[i]);
      write_("  }\n");
    }
    for (std::size_t i = 0; i < cameras_.size(); ++i) write_camera(i);
    if (scene_.stage) write_light(scene_.stage->light);
    write_("}\n");
  }

  Figures figures() const override {
    return {{"keys", count_}, {"between_frames_off_by_m", keys_.error()}};
  }

 private:
  struct Curve {
    std::string name, samples;
  };

  void add_key(const Snapshot& state) {
    ++count_;
    // Whole numbers at frames.
    const double code = std::round(state.time * scene_.fps * 1e9) / 1e9;
    for (std::size_t i = 0; i < connectors_.size(); ++i)
      connectors_[i].samples += fmt::format("      {}: {},\n", code, list(state.connectors[i]));
    for (std::size_t i = 0; i < bodies_.size(); ++i) bodies_[i].add(code, state.bodies[i]);
    for (std::size_t i = 0; i < cameras_.size(); ++i) {
      const scenes::CameraView view = scenes::camera_at(views_[i].keys, state.time);
      cameras_[i].add(code, {view.position, looking(view.target - view.position)});
      lenses_[i] += fmt::format("      {}: {},\n", code,
                                float(kAperture / 2 / std::tan(view.field_of_view / 2)));
      const double stop = view.relative_aperture > 0 ? 1 / view.relative_aperture : 0;
      stops_[i] += fmt::format("      {}: {},\n", code, float(stop));
      focuses_[i] += fmt::format("      {}: {},\n", code, float(view.focus));
    }
  }

  void write_connector(std::size_t i) {
    const scenes::ConnectorLook look = look_of(scene_, i);
    write_(fmt::format(
        "  def BasisCurves \"{}\"\n  {{\n    uniform token type = \"linear\"\n"
        "    int[] curveVertexCounts = [{}]\n"
        "    float[] widths = [{}] (\n      interpolation = \"constant\"\n    )\n"
        "    color3f[] primvars:displayColor = [{}] (\n      interpolation = \"constant\"\n    )\n"
        "    point3f[] points.timeSamples = {{\n",
        connectors_[i].name, world_.connectors[i].particles(), float(look.diameter),
        text(look.color)));
    write_(connectors_[i].samples);
    write_("    }\n  }\n");
  }

  void write_meshes(const scenes::Model& model) {
    Names names;
    for (const scenes::Mesh& mesh : model.meshes) {
      std::vector<std::array<float, 3>> points, normals, colors;
      const scenes::Material& material = model.materials[mesh.material];
      for (const scenes::Vertex& v : mesh.vertices) {
        points.push_back(v.position);
        normals.push_back(v.normal);
        auto& color = colors.emplace_back(v.color);
        for (std::size_t k = 0; k < 3; ++k) color[k] *= material.base_color[k];
      }
      write_(fmt::format(
          "    def Mesh \"{}\"\n    {{\n      uniform token subdivisionScheme = \"none\"\n"
          "      int[] faceVertexCounts = [{}]\n      int[] faceVertexIndices = [{}]\n",
          names.of(material.name), fmt::join(std::vector(mesh.indices.size() / 3, 3), ", "),
          fmt::join(mesh.indices, ", ")));
      write_(fmt::format("      point3f[] points = {}\n", list(points)));
      write_(
          fmt::format("      normal3f[] normals = {} (\n        interpolation = \"vertex\"\n"
                      "      )\n",
                      list(normals)));
      write_(
          fmt::format("      color3f[] primvars:displayColor = {} (\n"
                      "        interpolation = \"vertex\"\n      )\n    }}\n",
                      list(colors)));
    }
  }

  void write_camera(std::size_t i) {
    write_(fmt::format(
        "  def Camera \"{}\"\n  {{\n    float2 clippingRange = (0.05, 60)\n"
        "    float horizontalAperture = {}\n    float verticalAperture = {}\n"
        "    float focalLength.timeSamples = {{\n{}    }}\n",
        cameras_[i].name, float(kAperture * scene_.width / scene_.height), kAperture, lenses_[i]));
    if (std::ranges::any_of(views_[i].keys,
                            [](const auto& key) { return key.relative_aperture > 0; }))
      write_(
          fmt::format("    float fStop.timeSamples = {{\n{}    }}\n"
                      "    float focusDistance.timeSamples = {{\n{}    }}\n",
                      stops_[i], focuses_[i]));
    write_(cameras_[i].samples());
    write_("  }\n");
  }

  void write_light(const scenes::Light& light) {
    const double brightest = std::max(light.color.maxCoeff(), 1e-9);
    write_(
        fmt::format("  def DistantLight \"{}\"\n  {{\n    color3f inputs:color = {}\n"
                    "    float inputs:intensity = {}\n    quatf xformOp:orient = {}\n"
                    "    uniform token[] xformOpOrder = [\"xformOp:orient\"]\n  }}\n",
                    names_.of("key_light"), text(Vec3(light.color / brightest)), float(brightest),
                    text(looking(light.direction))));
  }

  static constexpr double kAperture = 24;  // mm, its height

  const scenes::Scene& scene_;
  WriteBytes write_;
  World world_;
  LinearKeys keys_;
  Names names_;
  std::vector<Curve> connectors_;
  std::vector<Placed> bodies_, cameras_;
  std::vector<NamedCamera> views_;
  // Time samples of the cameras' focal lengths, f-numbers (0: a pinhole) and distances of focus.
  std::vector<std::string> lenses_, stops_, focuses_;
  std::size_t count_ = 0;
};

}  // namespace

std::unique_ptr<FrameWriter> usda_writer(const scenes::Scene& scene, WriteBytes write) {
  return std::make_unique<UsdaWriter>(scene, std::move(write));
}

}  // namespace taut::exporting
