#include "render/draw/shading/room_light.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "sim/motion/stop.h"

namespace taut::draw {

std::array<Mat3, 6> cube_sides() {
  const auto side = [](const Vec3& across, const Vec3& up, const Vec3& ahead) {
    Mat3 m;
    m << across, up, ahead;
    return m;
  };
  const Vec3 x = Vec3::UnitX(), y = Vec3::UnitY(), z = Vec3::UnitZ();
  return {side(-z, -y, x), side(z, -y, -x), side(x, z, y),
          side(x, -z, -y), side(x, -y, z),  side(-x, -y, -z)};
}

CubePixel cube_pixel(const Mat3& side, int i, int j, int size) {
  const double s = (2 * i + 1.0) / size - 1, t = (2 * j + 1.0) / size - 1;
  const double square = 1 + s * s + t * t, width = 2.0 / size;
  return {(s * side.col(0) + t * side.col(1) + side.col(2)) / std::sqrt(square),
          width * width / (square * std::sqrt(square)), Vec3::Zero()};
}

Harmonics harmonics(std::span<const CubePixel> cube) {
  HarmonicSum sum;
  for (const CubePixel& p : cube) sum.add(p.direction, p.radiance, p.solid_angle);
  return sum.irradiance();
}

SideLight side_light(std::span<const CubePixel> cube) {
  std::array<Vec3, 6> sum;
  sum.fill(Vec3::Zero());
  for (const CubePixel& p : cube)
    for (int axis = 0; axis < 3; ++axis) {
      const double cosine = p.direction[axis];
      sum[std::size_t(2 * axis + (cosine < 0))] +=
          std::abs(cosine) * p.solid_angle / std::numbers::pi * p.radiance;
    }
  SideLight light;
  for (std::size_t k = 0; k < 6; ++k) light[k] = sum[k].cast<float>();
  return light;
}

CubeMips::CubeMips(std::span<const CubePixel> cube, int size) : size_(size) {
  std::vector<Vec3>& finest = levels_.emplace_back();
  for (const CubePixel& p : cube) finest.push_back(p.radiance);
  for (int wide = size / 2; wide > 0; wide /= 2) {
    const std::vector<Vec3> finer = levels_.back();
    std::vector<Vec3>& level = levels_.emplace_back();
    for (std::size_t row = 0; row < std::size_t(6 * wide); ++row)
      for (std::size_t column = 0; column < std::size_t(wide); ++column) {
        const std::size_t at = 4 * row * std::size_t(wide) + 2 * column;
        const std::size_t below = at + 2 * std::size_t(wide);
        level.push_back((finer[at] + finer[at + 1] + finer[below] + finer[below + 1]) / 4);
      }
  }
}

Vec3 CubeMips::from(const Vec3& direction, double solid_angle) const {
  int axis = 0;
  direction.cwiseAbs().maxCoeff(&axis);
  const std::size_t side = std::size_t(2 * axis + (direction[axis] < 0));
  const Mat3& axes = sides_[side];
  const double ahead = direction.dot(axes.col(2));
  const double s = direction.dot(axes.col(0)) / ahead, t = direction.dot(axes.col(1)) / ahead;
  const double pixels = solid_angle * size_ * size_ * 6 / (4 * std::numbers::pi);
  const int level = std::clamp(int(std::lround(0.5 * std::log2(std::max(pixels, 1.0)))), 0,
                               int(levels_.size()) - 1);
  const int wide = size_ >> level;
  const auto place = [wide](double x) {
    return std::size_t(std::clamp(int((x + 1) / 2 * wide), 0, wide - 1));
  };
  return levels_[std::size_t(level)]
                [(side * std::size_t(wide) + place(t)) * std::size_t(wide) + place(s)];
}

Vec3 CubeMips::blurred(const Vec3& ahead, double roughness) const {
  constexpr int kSamples = 64;
  const double a2 = std::pow(roughness, 4);
  const Vec3 right = ahead.unitOrthogonal(), up = ahead.cross(right);
  Vec3 sum = Vec3::Zero();
  double weights = 0;
  for (int i = 0; i < kSamples; ++i) {
    const double u = (i + 0.5) / kSamples, turn = std::numbers::pi * (3 - std::sqrt(5.0)) * i;
    const double nh2 = (1 - u) / (1 + (a2 - 1) * u);  // of the half vector, squared
    const double nl = 2 * nh2 - 1;
    if (nl <= 0) continue;
    const double d = nh2 * (a2 - 1) + 1;
    const double density = a2 / (std::numbers::pi * d * d) / 4;  // of the direction, 1/sr
    const double out = std::sqrt(1 - nl * nl);
    const Vec3 direction = nl * ahead + out * (std::cos(turn) * right + std::sin(turn) * up);
    sum += nl * from(direction, 1 / (kSamples * density));
    weights += nl;
  }
  return sum / weights;
}

namespace {

constexpr double kLeast = 1.0;        // m, a side of what encloses a room
constexpr double kWallMargin = 0.25;  // m, from the walls to the outermost points
constexpr std::array<std::array<int, 3>, 2> kPoints = {  // of the grid, by x, y, z
    {{3, 2, 3}, {5, 2, 6}}};               // as the first bounce is gathered, and the second
constexpr int kSide = 32;                  // px of the pictures
constexpr int kMirror = 128;               // px of the one that is mirrored
constexpr int kLevels = 5;                 // of roughness, from 0 to 1 evenly
constexpr double kNear = 0.02, kFar = 60;  // m, the latter of small rooms

using Eigen::Matrix4f;

/// World to clip space of a picture of a right angle.
Matrix4f projection(const Mat3& side, const Vec3& eye, double far) {
  Mat3 axes = side.transpose();
  axes.row(2) *= -1;  // OpenGL looks backwards
  Eigen::Matrix4d view = Eigen::Matrix4d::Identity(), lens = Eigen::Matrix4d::Identity();
  view.topLeftCorner<3, 3>() = axes;
  view.topRightCorner<3, 1>() = -axes * eye;
  lens(2, 2) = (far + kNear) / (kNear - far);
  lens(2, 3) = 2 * far * kNear / (kNear - far);
  lens(3, 2) = -1;
  lens(3, 3) = 0;
  return (lens * view).cast<float>();
}

/// Neighbouring triangles of a thing, which one side of a cube sees or does not.
struct Patch {
  std::span<const std::uint32_t> indices;
  Eigen::AlignedBox3d box;
};

std::vector<Patch> patches(const Drawable& thing) {
  constexpr std::size_t kIndices = 3 * 48;
  std::vector<Patch> list;
  const std::span<const std::uint32_t> all = thing.triangles();
  for (std::size_t first = 0; first < all.size(); first += kIndices) {
    Patch& patch = list.emplace_back();
    patch.indices = all.subspan(first, std::min(kIndices, all.size() - first));
    for (const std::uint32_t i : patch.indices)
      patch.box.extend(thing.positions()[i].cast<double>());
  }
  return list;
}

/// Whether a box may be in the right angle of a side that is seen from `eye`.
bool may_show(const Eigen::AlignedBox3d& box, const Mat3& side, const Vec3& eye) {
  for (const double sign : {-1.0, 1.0})
    for (const int axis : {0, 1}) {
      const Vec3 inwards = side.col(2) + sign * side.col(axis);
      const Vec3 farthest =
          (inwards.array() > 0).select(box.max() - eye, box.min() - eye);  // along it
      if (inwards.dot(farthest) < 0) return false;
    }
  return true;
}

Harmonics no_light() {
  Harmonics none;
  none.fill(Eigen::Vector3f::Zero());
  return none;
}

/// Takes cubes of pictures of the scenery.
class Photographer {
 public:
  Photographer(const gl::Gl& gl, const scenes::Light& light, std::span<Drawable> things,
               const SceneryShadow& shadow)
      : gl_(gl),
        light_(light),
        things_(things),
        surfaces_(gl, light, {no_light()}, shadow, 1, Output::radiance),
        color_(make_texture(gl, GL_RGBA32F, kMirror, kMirror)),
        depth_(make_texture(gl, GL_DEPTH_COMPONENT24, kMirror, kMirror)),
        target_(make_framebuffer(gl, color_.id(), depth_.id())),
        far_(std::max(kFar, box_around(things).diagonal().norm())) {
    for (const Drawable& thing : things) patches_.push_back(patches(thing));
  }

  /// Side by side, rows from t = -1; `size` px wide, at most kMirror.
  std::vector<CubePixel> take(const Vec3& eye, int size) {
    gl_.BindFramebuffer(GL_FRAMEBUFFER, target_.id());
    gl_.Viewport(0, 0, size, size);
    gl_.Enable(GL_DEPTH_TEST);
    gl_.DepthMask(GL_TRUE);
    gl_.DepthFunc(GL_LEQUAL);
    gl_.Enable(GL_CULL_FACE);
    gl_.CullFace(GL_BACK);
    gl_.Disable(GL_BLEND);
    gl_.Disable(GL_SCISSOR_TEST);
    gl_.ClearColor(0, 0, 0, 0);
    std::vector<CubePixel> cube;
    std::vector<Eigen::Vector4f> read(std::size_t(size * size));
    for (const Mat3& side : cube_sides()) {
      FrameBlock block({eye, eye + Vec3::UnitZ(), 1}, {0, 0, size, size});
      block.view_projection = projection(side, eye, far_);
      surfaces_.use(block);
      gl_.Clear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
      for (std::size_t i = 0; i < things_.size(); ++i) {
        indices_.clear();
        for (const Patch& patch : patches_[i])
          if (may_show(patch.box, side, eye))
            indices_.insert(indices_.end(), patch.indices.begin(), patch.indices.end());
        surfaces_.draw({{things_[i], Matrix4f::Identity()}, indices_}, Shade::lit);
      }
      gl_.PixelStorei(GL_PACK_ROW_LENGTH, size);
      gl_.ReadPixels(0, 0, size, size, GL_RGBA, GL_FLOAT, read.data());
      for (int j = 0; j < size; ++j)
        for (int i = 0; i < size; ++i) {
          CubePixel seen = cube_pixel(side, i, j, size);
          const Eigen::Vector4f& color = read[std::size_t(j * size + i)];
          seen.radiance = color.w() > 0 ? Vec3(color.head<3>().cast<double>())
                                        : surrounding_light(light_, seen.direction);
          cube.push_back(seen);
        }
    }
    return cube;
  }

 private:
  const gl::Gl& gl_;
  const scenes::Light& light_;
  std::span<Drawable> things_;
  Surfaces surfaces_;
  gl::GlObject color_, depth_, target_;
  double far_;                               // m
  std::vector<std::vector<Patch>> patches_;  // [thing]
  std::vector<std::uint32_t> indices_;
};

gl::GlObject mirror_texture(const gl::Gl& gl, std::span<const CubePixel> cube) {
  GLuint id = 0;
  gl.CreateTextures(GL_TEXTURE_CUBE_MAP, 1, &id);
  gl::GlObject texture(gl, id, [](const gl::Gl& g, GLuint i) { g.DeleteTextures(1, &i); });
  gl.TextureStorage2D(id, kLevels, GL_RGBA16F, kMirror, kMirror);
  gl.TextureParameteri(id, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  gl.TextureParameteri(id, GL_TEXTURE_MIN_FILTER, GL_LINEAR_MIPMAP_NEAREST);
  const auto sides = cube_sides();
  const CubeMips mips(cube, kMirror);
  for (int level = 0; level < kLevels; ++level) {
    const int size = kMirror >> level;
    std::vector<Eigen::Vector4f> colors;
    for (std::size_t side = 0; side < 6; ++side) {
      for (int j = 0; j < size; ++j)
        for (int i = 0; i < size; ++i) {
          const std::size_t at = (side * std::size_t(size) + std::size_t(j)) * std::size_t(size);
          const Vec3 light = level == 0
                                 ? cube[at + std::size_t(i)].radiance
                                 : mips.blurred(cube_pixel(sides[side], i, j, size).direction,
                                                double(level) / (kLevels - 1));
          colors.push_back({float(light.x()), float(light.y()), float(light.z()), 1});
        }
    }
    gl.TextureSubImage3D(id, level, 0, 0, 0, size, size, 6, GL_RGBA, GL_FLOAT, colors.data());
  }
  return texture;
}

}  // namespace

RoomLight::RoomLight(const gl::Gl& gl, const scenes::Light& light, std::span<Drawable> things,
                     std::span<const scenes::Mesh* const> meshes, const SceneryShadow& shadow,
                     const Vec3& middle) {
  room_ = box_around(things);
  if (room_.isEmpty() || room_.sizes().minCoeff() < kLeast) return;
  points_ = {room_.min() + Vec3::Constant(kWallMargin), room_.max() - Vec3::Constant(kWallMargin)};
  middle_ = middle.cwiseMax(points_.min()).cwiseMin(points_.max());
  Photographer photographer(gl, light, things, shadow);
  for (const std::array<int, 3>& points : kPoints) {
    count_ = points;
    grid_.clear();
    for (int k = 0; k < count_[2]; ++k)
      for (int j = 0; j < count_[1]; ++j)
        for (int i = 0; i < count_[0]; ++i) {
          check_stop();
          const Vec3 share(double(i) / (count_[0] - 1), double(j) / (count_[1] - 1),
                           double(k) / (count_[2] - 1));
          grid_.push_back(side_light(
              photographer.take(points_.min() + share.cwiseProduct(points_.sizes()), kSide)));
        }
    for (std::size_t i = 0; i < things.size(); ++i) things[i].bathe(on(*meshes[i]));
  }
  const std::vector<CubePixel> cube = photographer.take(middle_, kMirror);
  middle_light_ = harmonics(cube);
  mirror_ = mirror_texture(gl, cube);
}

SideLight RoomLight::at(const Vec3& point) const {
  std::array<int, 3> cell{};
  Vec3 share;
  for (int axis = 0; axis < 3; ++axis) {
    const int cells = count_[std::size_t(axis)] - 1;
    const double x = std::clamp((point[axis] - points_.min()[axis]) / points_.sizes()[axis] * cells,
                                0.0, double(cells));
    cell[std::size_t(axis)] = std::min(int(x), cells - 1);
    share[axis] = x - cell[std::size_t(axis)];
  }
  SideLight sum;
  sum.fill(Eigen::Vector3f::Zero());
  for (int corner = 0; corner < 8; ++corner) {
    const int i = corner & 1, j = corner >> 1 & 1, k = corner >> 2;
    const double weight = (i ? share.x() : 1 - share.x()) * (j ? share.y() : 1 - share.y()) *
                          (k ? share.z() : 1 - share.z());
    const SideLight& one =
        grid_[std::size_t(((cell[2] + k) * count_[1] + cell[1] + j) * count_[0] + cell[0] + i)];
    for (std::size_t n = 0; n < sum.size(); ++n) sum[n] += float(weight) * one[n];
  }
  return sum;
}

std::vector<Eigen::Vector3f> RoomLight::on(const scenes::Mesh& mesh) const {
  std::vector<Eigen::Vector3f> light;
  light.reserve(mesh.vertices.size());
  for (const scenes::Vertex& v : mesh.vertices) {
    const Eigen::Vector3f n = Eigen::Vector3f(v.normal.data()).normalized();
    const Vec3 place = Eigen::Vector3f(v.position.data()).cast<double>();
    const SideLight sides = at(place);
    Eigen::Vector3f sum = Eigen::Vector3f::Zero();
    for (int axis = 0; axis < 3; ++axis)
      sum += n[axis] * n[axis] * sides[std::size_t(2 * axis + (n[axis] < 0))];
    light.push_back(sum);
  }
  return light;
}

Surroundings RoomLight::surroundings() const {
  return {middle_light_, mirror_.id(), kLevels, room_, middle_};
}

}  // namespace taut::draw
