// The structure follows the glTF 2.0 specification (Khronos, 2021), sections 3.5 to 3.9 and 4.
#include "scenes/model/gltf.h"

#include <bit>
#include <cmath>
#include <map>
#include <set>

#include "scenes/model/gltf_source.h"
#include "scenes/model/gltf_textures.h"
#include "scenes/model/limits.h"

namespace taut::scenes {
namespace {

constexpr std::size_t triangles = 4, triangle_fan = 6;
constexpr std::size_t kNone = ~std::size_t{0};  // no index

void append32(std::string& bytes, std::size_t value) {
  for (int i = 0; i < 4; ++i) bytes += static_cast<char>(value >> 8 * i & 0xff);
}

class Reduction {
 public:
  Reduction(const GltfSource& source, NamedFiles& files) : in_(source), textures_(source, files) {}

  CheckedGltf run() {
    const std::vector<std::size_t> roots = walk_nodes();
    note_left_out();
    for (std::size_t i = 0; i < in_.list("materials").size(); ++i) copy_material(i);
    copy_skins();
    for (std::size_t i = 0; i < in_.list("meshes").size(); ++i) copy_mesh(i);
    if (!out_.contains("meshes")) in_.fail("has no triangles");
    copy_nodes(roots);
    checked_.glb = pack();
    checked_.textures = textures_.take();
    for (const auto& [what, where] : textures_.left_out()) leave_out(what, where);
    for (const auto& [what, found] : left_out_) {
      checked_.left_out.push_back(
          found.count == 1 ? fmt::format("{} ({})", what, found.where)
                           : fmt::format("{} ({}, {} in all)", what, found.where, found.count));
    }
    return std::move(checked_);
  }

 private:
  struct Found {
    std::string where;  // the first of them
    std::size_t count = 0;
  };

  void leave_out(const std::string& what, const std::string& where) {
    Found& found = left_out_[what];
    if (found.count++ == 0) found.where = where;
  }

  void note_left_out() {
    for (const char* key : {"animations", "cameras"}) {
      for (std::size_t i = 0; i < in_.list(key).size(); ++i) {
        leave_out(key, fmt::format("{}[{}]", key, i));
      }
    }
    if (in_.list("scenes").size() > 1) leave_out("scenes but one", "scenes");
    for (const Json& name : in_.list("extensionsUsed")) {
      leave_out(fmt::format("the extension {}", name.dump()), "extensionsUsed");
    }
  }

  /// Adds the accessor to the result, over a view of its own; its new index.
  std::size_t emit(const GltfAccessor& a) {
    const std::size_t item_size = a.item_size();
    Json view = {{"buffer", 0},
                 {"byteOffset", a.offset},
                 {"byteLength", (a.count - 1) * a.stride + item_size}};
    if (a.stride != item_size) view["byteStride"] = a.stride;
    out_["bufferViews"].push_back(view);
    Json accessor = {{"bufferView", out_["bufferViews"].size() - 1},
                     {"componentType", a.component},
                     {"count", a.count},
                     {"type", a.type}};
    if (a.normalized) accessor["normalized"] = true;
    out_["accessors"].push_back(accessor);
    return out_["accessors"].size() - 1;
  }

  /// Adds a share of few bits as floats, behind all that the source holds.
  std::size_t emit_floats(const GltfAccessor& a) {
    const float whole = a.component == u8 ? 255 : 65535;
    added_.resize((in_.binary().size() + added_.size() + 3) / 4 * 4 - in_.binary().size());
    const std::size_t offset = in_.binary().size() + added_.size(),
                      item_size = a.elements * sizeof(float);
    for (std::size_t k = 0; k < a.count; ++k)
      for (std::size_t e = 0; e < a.elements; ++e)
        append32(added_, std::bit_cast<std::uint32_t>(float(in_.integer(a, k, e)) / whole));
    out_["bufferViews"].push_back(
        {{"buffer", 0}, {"byteOffset", offset}, {"byteLength", a.count * item_size}});
    out_["accessors"].push_back({{"bufferView", out_["bufferViews"].size() - 1},
                                 {"componentType", f32},
                                 {"count", a.count},
                                 {"type", a.type}});
    return out_["accessors"].size() - 1;
  }

  // Nodes: a forest below the scene's roots.

  std::vector<std::size_t> walk_nodes() {
    const std::size_t count = in_.list("nodes").size();
    if (count > model_limits::nodes) in_.fail("more than {} nodes", model_limits::nodes);
    if (in_.list("scenes").empty()) in_.fail("has no scene");
    const std::size_t scene = in_.whole(in_.root(), "scene", "its JSON", 0);
    if (scene >= in_.list("scenes").size()) in_.fail("scene {} does not exist", scene);
    const Json& chosen = in_.item("scenes", scene);
    new_index_.assign(count, count);
    std::vector<std::size_t> roots;
    for (const Json& value : in_.list(chosen, "nodes", "its scene")) {
      roots.push_back(in_.index(value, count, "a scene's node"));
      visit(roots.back(), 0);
    }
    if (roots.empty()) in_.fail("its scene is empty");
    return roots;
  }

  void visit(std::size_t node, std::size_t depth) {
    if (depth > model_limits::depth)
      in_.fail("nodes nested more than {} deep", model_limits::depth);
    const std::size_t count = new_index_.size();
    if (new_index_[node] != count) in_.fail("nodes[{}] has two parents", node);
    new_index_[node] = order_.size();
    order_.push_back(node);
    const std::string where = fmt::format("nodes[{}]", node);
    for (const Json& child : in_.list(in_.item("nodes", node), "children", where))
      visit(in_.index(child, count, where + ".children"), depth + 1);
  }

  /// Counts what a node shows of a mesh.
  std::size_t show(std::size_t mesh) {
    shown_ += out_["meshes"][new_mesh_[mesh]]["primitives"].size();
    if (shown_ > model_limits::meshes)
      in_.fail("its nodes show more than {} primitives", model_limits::meshes);
    return new_mesh_[mesh];
  }

  void copy_nodes(const std::vector<std::size_t>& roots) {
    std::set<std::string> names;
    for (const std::size_t i : order_) {
      const std::string where = fmt::format("nodes[{}]", i);
      const Json& in = in_.item("nodes", i);
      Json node = Json::object();
      for (const auto& [key, size] : {std::pair<const char*, std::size_t>{"translation", 3},
                                      {"rotation", 4},
                                      {"scale", 3},
                                      {"matrix", 16}}) {
        if (!in.contains(key)) continue;
        const Json& values = in_.list(in, key, where);
        if (values.size() != size) in_.fail("{}.{} must have {} numbers", where, key, size);
        double norm = 0;
        for (const Json& value : values) norm += std::pow(in_.number(value, where + "." + key), 2);
        if (size == 4 && std::abs(norm - 1) > 1e-3) in_.fail("{}.rotation is not a unit", where);
        node[key] = values;
      }
      const std::size_t mesh =
          in.contains("mesh") ? in_.index(in["mesh"], new_mesh_.size(), where + ".mesh") : kNone;
      const bool shows = mesh != kNone && new_mesh_[mesh] != kNone;
      if (shows) node["mesh"] = show(mesh);
      if (in.contains("skin")) {
        const std::size_t skin = in_.index(in["skin"], out_["skins"].size(), where + ".skin");
        if (shows) check_joints(mesh, node["skin"] = skin);
      }
      // Bones are found by name: names must differ, and no mesh may take a joint's.
      std::string unique = in_.name(in, fmt::format("node {}", i));
      if (in.contains("mesh") && !joints_.contains(i)) unique = "mesh:" + unique;
      if (!names.insert(unique).second) {
        if (joints_.contains(i)) in_.fail("two nodes are named \"{}\"", unique);
        names.insert(unique = fmt::format("{}#{}", unique, i));
      }
      node["name"] = unique;
      for (const Json& child : in_.list(in, "children", where))
        node["children"].push_back(new_index_[child.get<std::size_t>()]);
      out_["nodes"].push_back(node);
    }
    Json scene = {{"nodes", Json::array()}};
    for (const std::size_t root : roots) scene["nodes"].push_back(new_index_[root]);
    out_["scenes"].push_back(scene);
    out_["scene"] = 0;
  }

  // Skins, meshes and materials.

  void copy_skins() {
    out_["skins"] = Json::array();
    for (std::size_t i = 0; i < in_.list("skins").size(); ++i) {
      const std::string where = fmt::format("skins[{}]", i);
      const Json& in = in_.item("skins", i);
      Json skin = {{"joints", Json::array()}};
      for (const Json& value : in_.list(in, "joints", where)) {
        const std::size_t joint = in_.index(value, new_index_.size(), where + ".joints");
        if (new_index_[joint] == new_index_.size()) in_.fail("{}.joints: not in the scene", where);
        joints_.insert(joint);
        skin["joints"].push_back(new_index_[joint]);
      }
      const std::size_t count = skin["joints"].size();
      if (count == 0 || count > model_limits::bones)
        in_.fail("{} has {} joints, expected 1 to {}", where, count, model_limits::bones);
      if (!in.contains("inverseBindMatrices")) in_.fail("{} lacks inverseBindMatrices", where);
      const GltfAccessor a =
          in_.accessor(in["inverseBindMatrices"], where + ".inverseBindMatrices");
      if (a.type != "MAT4" || a.component != f32 || a.count != count)
        in_.fail("{}.inverseBindMatrices must be {} float matrices", where, count);
      skin["inverseBindMatrices"] = emit(a);
      out_["skins"].push_back(skin);
    }
  }

  void check_joints(std::size_t mesh, std::size_t skin) const {
    if (highest_joint_[mesh] >= out_.at("skins")[skin]["joints"].size())
      in_.fail("meshes[{}] names joint {}, but its skin has {}", mesh, highest_joint_[mesh],
               out_.at("skins")[skin]["joints"].size());
  }

  void copy_mesh(std::size_t i) {
    const std::string where = fmt::format("meshes[{}]", i);
    const Json& in = in_.item("meshes", i);
    Json mesh = {{"name", in_.name(in, fmt::format("mesh {}", i))}, {"primitives", Json::array()}};
    highest_joint_.push_back(0);
    for (const Json& primitive : in_.list(in, "primitives", where)) {
      if (!primitive.is_object()) in_.fail("{}.primitives must be objects", where);
      if (++primitives_ > model_limits::meshes)
        in_.fail("more than {} primitives", model_limits::meshes);
      const std::size_t mode = in_.whole(primitive, "mode", where, triangles);
      if (mode > triangle_fan) in_.fail("{} has a primitive of mode {}", where, mode);
      if (mode < triangles) {
        leave_out("points and lines", where);
      } else {
        mesh["primitives"].push_back(copy_primitive(primitive, mode, where));
      }
    }
    if (in_.list(in, "primitives", where).empty()) in_.fail("{} has no primitives", where);
    new_mesh_.push_back(mesh["primitives"].empty() ? kNone : out_["meshes"].size());
    if (!mesh["primitives"].empty()) out_["meshes"].push_back(mesh);
  }

  Json copy_primitive(const Json& in, std::size_t mode, const std::string& where) {
    if (in.contains("targets")) leave_out("morph targets", where);
    Json out = {{"mode", mode}, {"attributes", Json::object()}};
    const auto attributes = in.find("attributes");
    if (attributes == in.end() || !attributes->is_object() || !attributes->contains("POSITION"))
      in_.fail("{} has a primitive without POSITION", where);
    const std::size_t count = in_.accessor((*attributes)["POSITION"], where + " POSITION").count;
    vertices_ += count;
    if (vertices_ > model_limits::vertices)
      in_.fail("more than {} vertices", model_limits::vertices);
    if (attributes->contains("JOINTS_1")) in_.fail("{} has more than 4 weights per vertex", where);
    if (attributes->contains("JOINTS_0") != attributes->contains("WEIGHTS_0"))
      in_.fail("{} must have both JOINTS_0 and WEIGHTS_0, or neither", where);

    for (const char* key : {"POSITION", "NORMAL", "COLOR_0", "JOINTS_0", "WEIGHTS_0"}) {
      if (!attributes->contains(key)) continue;
      const std::string what = where + " " + key;
      const GltfAccessor a = in_.accessor((*attributes)[key], what);
      if (a.count != count) in_.fail("{} has {} items, but POSITION {}", what, a.count, count);
      const bool is_float = a.component == f32;
      const bool is_short = a.component == u8 || a.component == u16;
      bool fits = a.type == "VEC3" && is_float;
      if (key[0] == 'C')
        fits = (a.type == "VEC3" || a.type == "VEC4") && (is_float || (is_short && a.normalized));
      if (key[0] == 'J') fits = a.type == "VEC4" && is_short;
      if (key[0] == 'W') fits = a.type == "VEC4" && (is_float || (is_short && a.normalized));
      if (!fits) in_.fail("{} of type {} {} is not read", what, a.type, a.component);
      if (key[0] == 'J') note_joints(a);
      out["attributes"][key] = key[0] == 'W' && is_short ? emit_floats(a) : emit(a);
    }
    if (in.contains("indices")) {
      const GltfAccessor a = in_.accessor(in["indices"], where + ".indices");
      if (a.type != "SCALAR" || a.component == f32 || a.component % 2 == 0)
        in_.fail("{}.indices must be unsigned integers", where);
      indices_ += a.count;
      if (indices_ > model_limits::indices) in_.fail("more than {} indices", model_limits::indices);
      for (std::size_t k = 0; k < a.count; ++k)
        if (in_.integer(a, k, 0) >= count)
          in_.fail("{} has index {}, but {} vertices", where, in_.integer(a, k, 0), count);
      out["indices"] = emit(a);
    }
    if (in.contains("material")) {
      const std::size_t material =
          in_.index(in["material"], in_.list("materials").size(), where + ".material");
      out["material"] = material;
      if (checked_.texture_of[material] >= 0)
        copy_coordinates(*attributes, coordinates_of(material), count, where, out);
    }
    return out;
  }

  /// The set of coordinates that the texture of a material takes.
  std::size_t coordinates_of(std::size_t material) const {
    const Json& pbr = in_.item("materials", material)["pbrMetallicRoughness"];
    return in_.whole(pbr["baseColorTexture"], "texCoord", "baseColorTexture", 0);
  }

  /// Where the vertices are on the texture, as the only such set.
  void copy_coordinates(const Json& attributes, std::size_t set, std::size_t count,
                        const std::string& where, Json& out) {
    const std::string key = fmt::format("TEXCOORD_{}", set), what = where + " " + key;
    if (!attributes.contains(key))
      return leave_out(fmt::format("a texture without {}", key), where);
    const GltfAccessor a = in_.accessor(attributes[key], what);
    if (a.count != count) in_.fail("{} has {} items, but POSITION {}", what, a.count, count);
    const bool is_share = (a.component == u8 || a.component == u16) && a.normalized;
    if (a.type != "VEC2" || (a.component != f32 && !is_share))
      in_.fail("{} of type {} {} is not read", what, a.type, a.component);
    out["attributes"]["TEXCOORD_0"] = is_share ? emit_floats(a) : emit(a);
  }

  void note_joints(const GltfAccessor& a) {
    for (std::size_t k = 0; k < a.count; ++k)
      for (std::size_t e = 0; e < 4; ++e)
        highest_joint_.back() = std::max<std::size_t>(highest_joint_.back(), in_.integer(a, k, e));
  }

  void copy_material(std::size_t i) {
    const std::string where = fmt::format("materials[{}]", i);
    const Json& in = in_.item("materials", i);
    checked_.texture_of.push_back(-1);
    Json factors = Json::object();
    if (const auto pbr = in.find("pbrMetallicRoughness"); pbr != in.end() && pbr->is_object()) {
      if (pbr->contains("baseColorFactor")) {
        const Json& color = in_.list(*pbr, "baseColorFactor", where);
        if (color.size() != 4) in_.fail("{}.baseColorFactor must have 4 numbers", where);
        for (const Json& value : color) in_.number(value, where + ".baseColorFactor");
        factors["baseColorFactor"] = color;
      }
      for (const char* key : {"metallicFactor", "roughnessFactor"})
        if (pbr->contains(key)) factors[key] = in_.number((*pbr)[key], where + "." + key);
      if (pbr->contains("metallicRoughnessTexture")) leave_out("metallicRoughnessTexture", where);
      if (const auto texture = pbr->find("baseColorTexture"); texture != pbr->end())
        checked_.texture_of.back() = textures_.index_of(*texture, where + ".baseColorTexture");
    }
    for (const char* key : {"normalTexture", "occlusionTexture", "emissiveTexture"})
      if (in.contains(key)) leave_out(key, where);
    if (const auto mode = in.find("alphaMode"); mode != in.end() && *mode != "OPAQUE")
      leave_out("transparency", where);
    for (const Json& light : in_.list(in, "emissiveFactor", where)) {
      if (in_.number(light, where + ".emissiveFactor") == 0) continue;
      leave_out("emitted light", where);
      break;
    }
    out_["materials"].push_back(
        {{"name", in_.name(in, fmt::format("material {}", i))}, {"pbrMetallicRoughness", factors}});
  }

  std::string pack() {
    out_["asset"] = {{"version", "2.0"}};
    const std::size_t size = in_.binary().size() + added_.size();
    out_["buffers"] = {{{"byteLength", size}}};
    if (in_.binary().empty()) in_.fail("holds no data");
    if (out_["skins"].empty()) out_.erase("skins");
    std::string text = out_.dump();
    text.resize((text.size() + 3) / 4 * 4, ' ');
    std::string glb = "glTF";
    append32(glb, 2);
    append32(glb, 12 + 8 + text.size() + 8 + size);
    append32(glb, text.size());
    glb += "JSON" + text;
    append32(glb, size);
    glb.append("BIN\0", 4);
    return glb + in_.binary() + added_;
  }

  const GltfSource& in_;
  CheckedGltf checked_;
  GltfTextures textures_;
  std::vector<std::size_t>
      coordinates_;  // for each material the set of them that its texture takes
  Json out_;
  std::string added_;                   // to the source's data
  std::vector<std::size_t> new_index_;  // of a node, or the number of nodes: not in the scene
  std::vector<std::size_t> order_;      // nodes of the scene, parents first
  std::vector<std::size_t> new_mesh_;   // kNone: it has no triangles
  std::set<std::size_t> joints_;
  std::map<std::string, Found> left_out_;
  std::vector<std::size_t> highest_joint_;  // that a mesh names
  std::size_t vertices_ = 0, indices_ = 0, primitives_ = 0;
  std::size_t shown_ = 0;  // primitives, as often as nodes show them
};

}  // namespace

std::optional<CheckedGltf> checked_gltf(const std::filesystem::path& file,
                                        const std::string& content, NamedFiles& files) {
  try {
    const GltfSource source(file, content, files);
    if (!files.wanted().empty()) return {};
    CheckedGltf checked = Reduction(source, files).run();
    if (!files.wanted().empty()) return {};
    return checked;
  } catch (const Json::exception& error) {  // a value of another type than anything looks for
    throw bad_asset(file, error.what());
  }
}

}  // namespace taut::scenes
