// Plays animated binary glTF files, as section 3.11 and appendix C of glTF 2.0 have it.
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <cstring>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <vector>

namespace taut {

class GlbFile {
 public:
  using Json = nlohmann::json;
  using Numbers = std::vector<double>;

  explicit GlbFile(const std::string& bytes) {
    const auto word = [&](std::size_t at) {
      std::uint32_t value = 0;
      if (at + 4 > bytes.size()) throw std::runtime_error("the file ends too early");
      std::memcpy(&value, bytes.data() + at, 4);
      return std::size_t(value);
    };
    if (word(0) != 0x46546c67 || word(4) != 2 || word(8) != bytes.size())
      throw std::runtime_error("no glTF file");
    const std::size_t json = word(12), binary = 20 + json;
    root_ = Json::parse(bytes.substr(20, json));
    buffer_ = bytes.substr(binary + 8, word(binary));
    parent_.assign(root_["nodes"].size(), kNone);
    for (std::size_t i = 0; i < parent_.size(); ++i)
      for (const std::size_t child : root_["nodes"][i].value("children", Json::array()))
        parent_[child] = i;
    if (!root_.contains("animations")) return;
    for (const Json& animation : root_["animations"])
      for (const Json& channel : animation["channels"]) {
        const Json& sampler = animation["samplers"][channel["sampler"].get<std::size_t>()];
        channels_.push_back({channel["target"]["node"], channel["target"]["path"],
                             sampler["interpolation"] == "CUBICSPLINE", numbers(sampler["input"]),
                             numbers(sampler["output"])});
      }
  }

  const Json& root() const { return root_; }

  std::size_t node(const std::string& name) const {
    const Json& nodes = root_["nodes"];
    for (std::size_t i = 0; i < nodes.size(); ++i)
      if (nodes[i].value("name", "") == name) return i;
    throw std::runtime_error("no node " + name);
  }

  /// All numbers of an accessor; normalized integers as shares of one.
  Numbers numbers(std::size_t accessor) const {
    const Json& a = root_["accessors"].at(accessor);
    const Json& view = root_["bufferViews"].at(a["bufferView"].get<std::size_t>());
    const std::string type = a["type"];
    const std::size_t size = type == "SCALAR" ? 1
                             : type == "MAT4" ? 16
                                              : std::size_t(type[3] - '0');
    const char* const from = buffer_.data() + view["byteOffset"].get<std::size_t>();
    Numbers result(a["count"].get<std::size_t>() * size);
    const auto read = [&]<typename T>(T, double one) {
      if (view["byteLength"] != result.size() * sizeof(T)) throw std::runtime_error("wrong length");
      for (std::size_t i = 0; i < result.size(); ++i) {
        T value;
        std::memcpy(&value, from + i * sizeof(T), sizeof(T));
        result[i] = double(value) / (a.value("normalized", false) ? one : 1);
      }
    };
    switch (a["componentType"].get<int>()) {
      case 5126:
        read(float(), 1);
        break;
      case 5122:
        read(std::int16_t(), 32767);
        break;
      case 5121:
        read(std::uint8_t(), 255);
        break;
      case 5123:
        read(std::uint16_t(), 65535);
        break;
      case 5125:
        read(std::uint32_t(), 1);
        break;
      default:
        throw std::runtime_error("unknown component");
    }
    return result;
  }

  /// Of the animation, s.
  Numbers keys() const {
    Numbers longest;
    for (const Channel& channel : channels_)
      if (channel.times.size() > longest.size()) longest = channel.times;
    return longest;
  }

  /// From a node's axes to the world's at that time.
  Eigen::Affine3d world(std::size_t node, double time) const {
    Eigen::Affine3d place = Eigen::Affine3d::Identity();
    for (; node != kNone; node = parent_[node]) place = local(node, time) * place;
    return place;
  }

  /// The same by the nodes' own places, whatever moves them.
  Eigen::Affine3d resting(std::size_t node) const {
    Eigen::Affine3d place = Eigen::Affine3d::Identity();
    for (; node != kNone; node = parent_[node]) {
      const Json& n = root_["nodes"][node];
      const Numbers t = n.value("translation", Numbers{0, 0, 0}),
                    r = n.value("rotation", Numbers{0, 0, 0, 1});
      place = Eigen::Translation3d(t[0], t[1], t[2]) *
              Eigen::Quaterniond(r[3], r[0], r[1], r[2]).normalized() * place;
    }
    return place;
  }

  /// The vertices of a skinned node at that time, of one primitive.
  std::vector<Eigen::Vector3d> skinned(std::size_t node, std::size_t primitive, double time) const {
    const Json& n = root_["nodes"][node];
    const Json& skin = root_["skins"][n["skin"].get<std::size_t>()];
    const Json& attributes = attributes_of(node, primitive);
    const Numbers positions = numbers(attributes["POSITION"]);
    const Numbers joints = numbers(attributes["JOINTS_0"]);
    const Numbers weights = numbers(attributes["WEIGHTS_0"]);
    const Numbers inverse = numbers(skin["inverseBindMatrices"]);
    std::vector<Eigen::Matrix4d> moves;
    for (std::size_t k = 0; k < skin["joints"].size(); ++k)
      moves.push_back(world(skin["joints"][k], time).matrix() *
                      Eigen::Map<const Eigen::Matrix4d>(inverse.data() + 16 * k));
    std::vector<Eigen::Vector3d> vertices;
    for (std::size_t i = 0; 3 * i < positions.size(); ++i) {
      const Eigen::Vector4d at(positions[3 * i], positions[3 * i + 1], positions[3 * i + 2], 1);
      Eigen::Vector4d sum = Eigen::Vector4d::Zero();
      for (std::size_t k = 4 * i; k < 4 * i + 4; ++k)
        sum += weights[k] * (moves.at(std::size_t(joints[k])) * at);
      vertices.push_back(sum.head<3>());
    }
    return vertices;
  }

  const Json& attributes_of(std::size_t node, std::size_t primitive) const {
    const std::size_t mesh = root_["nodes"][node]["mesh"];
    return root_["meshes"][mesh]["primitives"][primitive]["attributes"];
  }

 private:
  static constexpr std::size_t kNone = std::size_t(-1);
  struct Channel {
    std::size_t node;
    std::string path;
    bool cubic;
    Numbers times, values;
  };

  Eigen::Affine3d local(std::size_t node, double time) const {
    const Json& n = root_["nodes"][node];
    const auto read = [&](const char* path, Numbers value) {
      if (n.contains(path)) value = n[path].get<Numbers>();
      for (const Channel& channel : channels_)
        if (channel.node == node && channel.path == path) return play(channel, time);
      return value;
    };
    const Numbers t = read("translation", {0, 0, 0}), r = read("rotation", {0, 0, 0, 1});
    return Eigen::Translation3d(t[0], t[1], t[2]) *
           Eigen::Quaterniond(r[3], r[0], r[1], r[2]).normalized();
  }

  static Numbers play(const Channel& channel, double time) {
    const Numbers& times = channel.times;
    const std::size_t size = channel.path == "rotation" ? 4 : 3;
    const auto after = std::ranges::upper_bound(times, time);
    const auto value = [&](std::size_t key, std::size_t part) {
      const std::size_t at = (channel.cubic ? 3 * key + part : key) * size;
      return Eigen::Map<const Eigen::VectorXd>(channel.values.data() + at, Eigen::Index(size));
    };
    const auto listed = [](const Eigen::VectorXd& v) { return Numbers(v.begin(), v.end()); };
    if (after == times.begin()) return listed(value(0, 1));
    const auto k = std::size_t(after - times.begin()) - 1;
    if (after == times.end()) return listed(value(k, 1));
    const double span = times[k + 1] - times[k], u = (time - times[k]) / span;
    if (channel.cubic) {
      const double u2 = u * u, u3 = u2 * u;
      return listed((2 * u3 - 3 * u2 + 1) * value(k, 1) + span * (u3 - 2 * u2 + u) * value(k, 2) +
                    (3 * u2 - 2 * u3) * value(k + 1, 1) + span * (u3 - u2) * value(k + 1, 0));
    }
    if (size == 3) return listed((1 - u) * value(k, 0) + u * value(k + 1, 0));
    const Eigen::Quaterniond from(Eigen::Vector4d(value(k, 0))),
        to(Eigen::Vector4d(value(k + 1, 0)));
    return listed(from.normalized().slerp(u, to.normalized()).coeffs());
  }

  Json root_;
  std::string buffer_;
  std::vector<std::size_t> parent_;
  std::vector<Channel> channels_;
};

}  // namespace taut
