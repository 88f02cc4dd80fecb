#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <optional>
#include <string_view>

#include "scenes/files/files.h"
#include "scenes/model/formats.h"
#include "scenes/model/model.h"
#include "sim/motion/printable.h"

namespace taut::scenes {
namespace {

constexpr double kMost = 1e6;  // of a length or an angle

/// A rod from a joint to another, as thick as bones look.
void add_rod(const Vec3& from, const Vec3& to, std::size_t bone, Mesh& mesh) {
  constexpr double kThick = 0.08, kThickest = 0.2;  // of its length: half its width, and where
  const Vec3 along = to - from, aside = along.unitOrthogonal();
  const Vec3 other = along.normalized().cross(aside);
  const double half = kThick * along.norm();
  const std::array<Vec3, 6> corners = {from,
                                       from + kThickest * along + half * aside,
                                       from + kThickest * along + half * other,
                                       from + kThickest * along - half * aside,
                                       from + kThickest * along - half * other,
                                       to};
  constexpr std::array<std::array<std::size_t, 3>, 8> kFaces = {
      {{0, 2, 1}, {0, 3, 2}, {0, 4, 3}, {0, 1, 4}, {5, 1, 2}, {5, 2, 3}, {5, 3, 4}, {5, 4, 1}}};
  for (const auto& face : kFaces) {
    const Vec3 a = corners[face[0]], b = corners[face[1]], c = corners[face[2]];
    const Eigen::Vector3f normal = (b - a).cross(c - a).normalized().cast<float>();
    for (const Vec3& at : {a, b, c}) {
      Vertex vertex;
      vertex.position = {float(at.x()), float(at.y()), float(at.z())};
      vertex.normal = {normal.x(), normal.y(), normal.z()};
      vertex.bones[0] = static_cast<std::uint16_t>(bone);
      vertex.weights[0] = 1;
      mesh.indices.push_back(static_cast<std::uint32_t>(mesh.vertices.size()));
      mesh.vertices.push_back(vertex);
    }
  }
}

class Bvh {
 public:
  Bvh(const std::filesystem::path& file, std::string_view text) : file_(file), left_(text) {
    if (left_.starts_with("\xef\xbb\xbf")) left_.remove_prefix(3);
    if (left_.find('\0') != left_.npos) throw bad_asset(file_, "not a text file");
  }

  Model run() {
    model_.name = file_.stem().string();
    model_.materials.emplace_back().name = "bones";
    model_.meshes.emplace_back().name = "bones";
    expect("HIERARCHY");
    std::string_view word = next();
    while (word == "ROOT") {
      read_joint(-1, Vec3::Zero(), 0);
      word = next();
    }
    if (word != "MOTION") fail(fmt::format("found \"{}\", expected ROOT or MOTION", word));
    if (model_.bones.empty()) throw bad_asset(file_, "has no joints");
    read_motion();
    if (model_.meshes[0].indices.empty()) throw bad_asset(file_, "its joints are all at one place");
    return std::move(model_);
  }

 private:
  /// One number of a frame: x, y or z of a joint's position, or an angle about x, y or z.
  struct Channel {
    std::size_t bone = 0;
    bool turns = false;
    int axis = 0;
  };

  [[noreturn]] void fail(const std::string& cause) const {
    throw bad_asset(file_, printable(fmt::format("line {}: {}", line_, cause)));
  }

  /// The next word; nothing at the end of the file.
  std::string_view next() {
    constexpr std::string_view blanks = " \t\r\v\f\n";
    std::size_t start = 0;
    while (start < left_.size() && blanks.find(left_[start]) != blanks.npos)
      line_ += left_[start++] == '\n';
    left_.remove_prefix(start);
    const std::string_view word = left_.substr(0, left_.find_first_of(blanks));
    left_.remove_prefix(word.size());
    return word.substr(0, 200);
  }

  void expect(std::string_view what) {
    const std::string_view word = next();
    if (word != what) fail(fmt::format("found \"{}\", expected {}", word, what));
  }

  double number() {
    std::string_view word = next();
    const std::string_view whole = word;
    if (word.starts_with('+')) word.remove_prefix(1);
    double value = 0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (error != std::errc() || end != word.data() + word.size() || !(std::abs(value) <= kMost))
      fail(fmt::format("found \"{}\", expected a number", whole));
    return value;
  }

  /// A joint, its name first; `above` is where its parent is at rest.
  void read_joint(int parent, const Vec3& above, std::size_t depth) {
    if (depth > model_limits::depth)
      fail(fmt::format("joints nested more than {} deep", model_limits::depth));
    if (model_.bones.size() == model_limits::bones)
      fail(fmt::format("more than {} joints", model_limits::bones));
    const std::size_t bone = model_.bones.size();
    model_.bones.emplace_back().parent = parent;
    std::string name;
    for (std::string_view word = next(); word != "{"; word = next()) {
      if (word.empty() || name.size() > 200) fail("a joint without {");
      name += fmt::format("{}{}", name.empty() ? "" : " ", word);
    }
    name = printable(name);
    if (model_.bone(name) >= 0) name += fmt::format("#{}", bone);
    model_.bones[bone].name = name;
    Vec3 at = above;
    for (std::string_view word = next(); word != "}"; word = next()) {
      if (word == "OFFSET") {
        model_.bones[bone].rest.position = read_offset();
        at = above + model_.bones[bone].rest.position;
        if (parent >= 0) rod(above, at, static_cast<std::size_t>(parent));
      } else if (word == "CHANNELS") {
        read_channels(bone);
      } else if (word == "JOINT") {
        read_joint(static_cast<int>(bone), at, depth + 1);
      } else if (word == "End") {
        expect("Site");
        expect("{");
        expect("OFFSET");
        rod(at, at + read_offset(), bone);
        expect("}");
      } else {
        fail(fmt::format("found \"{}\", expected OFFSET, CHANNELS, JOINT, End or }}", word));
      }
    }
    model_.bones[bone].inverse_bind.topRightCorner<3, 1>() = -at.cast<float>();
  }

  Vec3 read_offset() {
    const double x = number(), y = number(), z = number();
    return {x, y, z};
  }

  void rod(const Vec3& from, const Vec3& to, std::size_t bone) {
    if ((to - from).norm() > 1e-9) add_rod(from, to, bone, model_.meshes[0]);
  }

  void read_channels(std::size_t bone) {
    const double count = number();
    for (int i = 0; i < count; ++i) {
      const std::string_view word = next();
      Channel channel{bone, word.ends_with("rotation"), 0};
      if ((!channel.turns && !word.ends_with("position")) || word.size() != 9 || word[0] < 'X' ||
          word[0] > 'Z')
        fail(
            fmt::format("found \"{}\", expected Xposition, Yposition, Zposition, Xrotation, "
                        "Yrotation or Zrotation",
                        word));
      channel.axis = word[0] - 'X';
      channels_.push_back(channel);
      if (channels_.size() > 6 * model_limits::bones) fail("too many channels");
    }
  }

  void read_motion() {
    expect("Frames:");
    const double frames = number();
    if (!(frames >= 1 && frames == std::floor(frames))) fail("expected one frame or more");
    if (frames * 7 * static_cast<double>(model_.bones.size()) > double{model_limits::keys})
      fail(fmt::format("its frames have more than {} numbers", model_limits::keys));
    expect("Frame");
    expect("Time:");
    const double step = number();
    if (!(step > 0)) fail("expected a Frame Time above 0 s");
    // One track for what moves of each joint.
    std::vector<std::optional<std::size_t>> places(model_.bones.size()), turns(places.size());
    std::vector<BoneTrack>& tracks = model_.animations.emplace_back().tracks;
    model_.animations[0].name = "motion";
    for (const Channel& channel : channels_) {
      auto& track = (channel.turns ? turns : places)[channel.bone];
      if (track) continue;
      track = tracks.size();
      tracks.emplace_back().bone = static_cast<std::uint32_t>(channel.bone);
      tracks.back().of = channel.turns ? BoneTrack::Of::rotation : BoneTrack::Of::position;
    }
    std::vector<Pose> poses(model_.bones.size());
    for (int k = 0; k < frames; ++k) {
      for (std::size_t i = 0; i < poses.size(); ++i) poses[i] = model_.bones[i].rest;
      for (const Channel& channel : channels_) {
        const double value = number();
        Pose& pose = poses[channel.bone];
        if (channel.turns) {
          pose.rotation =
              pose.rotation * Quat(Eigen::AngleAxisd(value * M_PI / 180, Vec3::Unit(channel.axis)));
        } else {
          pose.position[channel.axis] = value;
        }
      }
      for (BoneTrack& track : tracks) {
        const Pose& pose = poses[track.bone];
        track.times.push_back(k * step);
        const Eigen::Vector4d turn = pose.rotation.normalized().coeffs();
        for (std::size_t e = 0; e < track.size(); ++e) {
          const auto i = static_cast<Eigen::Index>(e);
          track.values.push_back(
              static_cast<float>(track.of == BoneTrack::Of::position ? pose.position[i] : turn[i]));
        }
      }
    }
    if (const std::string_view word = next(); !word.empty())
      fail(fmt::format("found \"{}\" after the last of {} frames", word, frames));
  }

  const std::filesystem::path& file_;
  std::string_view left_;
  std::size_t line_ = 1;
  Model model_;
  std::vector<Channel> channels_;
};

}  // namespace

Model read_bvh(const std::filesystem::path& file, const std::string& content) {
  return Bvh(file, content).run();
}

}  // namespace taut::scenes
