#include "render/draw/shading/shadow_map.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <limits>
#include <vector>

#include "render/draw/shading/lighting.h"
#include "render/gl/shaders.h"

namespace taut::draw {
namespace {

constexpr GLenum kFormat = GL_DEPTH_COMPONENT16;  // a sixth of a millimetre on 11 m

}  // namespace

ShadowMap::ShadowMap(const gl::Gl& gl, int size)
    : gl_(gl),
      size_(size),
      map_(gl::make_texture(gl, kFormat, size, size)),
      target_(gl::make_framebuffer(gl, 0, map_.id())),
      depths_(gl::make_depth_sampler(gl)),
      depth_program_(gl, gl::shaders::frame_block, gl::shaders::depth_vertex,
                     gl::shaders::depth_fragment) {
  gl.TextureParameteri(map_.id(), GL_TEXTURE_COMPARE_MODE, GL_COMPARE_REF_TO_TEXTURE);
  gl.TextureParameteri(map_.id(), GL_TEXTURE_COMPARE_FUNC, GL_LEQUAL);
}

void ShadowMap::bind() const {
  gl_.BindTextureUnit(0, map_.id());
  gl_.BindTextureUnit(4, map_.id());
  gl_.BindSampler(4, depths_.id());
  if (layers_) gl_.BindTextureUnit(8, layers_.id());
}

void ShadowMap::clear() const {
  gl_.BindFramebuffer(GL_FRAMEBUFFER, target_.id());
  gl_.Viewport(0, 0, size_, size_);
  gl_.Clear(GL_DEPTH_BUFFER_BIT);
}

void ShadowMap::draw(std::span<const DrawItem> casters) const {
  draw(target_, 0, 0, casters);
}

void ShadowMap::draw_layer(int layer, std::span<const DrawItem> casters) const {
  draw(layer_targets_[std::size_t(layer)], layered_.x, layered_.y, casters);
}

/// Into a target whose corner is at (x, y) of the map.
void ShadowMap::draw(const gl::GlObject& target, int x, int y,
                     std::span<const DrawItem> casters) const {
  gl_.BindFramebuffer(GL_FRAMEBUFFER, target.id());
  gl_.Viewport(-x, -y, size_, size_);
  gl_.Enable(GL_SCISSOR_TEST);
  gl_.Scissor(2 - x, 2 - y, size_ - 4, size_ - 4);
  gl_.Enable(GL_DEPTH_CLAMP);
  gl_.Enable(GL_POLYGON_OFFSET_FILL);
  gl_.PolygonOffset(1.5f, 2.0f);
  depth_program_.use();
  for (const DrawItem& item : casters) {
    if (item.triangles.empty()) continue;
    depth_program_.set("model", item.model);
    item.draw();
  }
  gl_.Disable(GL_POLYGON_OFFSET_FILL);
  gl_.Disable(GL_DEPTH_CLAMP);
  gl_.Disable(GL_SCISSOR_TEST);
}

void ShadowMap::start_layers(const picture::Rect& part, int count) {
  constexpr int kMore = 128;  // texels, so that they are not made anew for every texel
  const auto enough = [&](int had, int needed) {
    return std::max(had, std::min((needed + kMore - 1) / kMore * kMore, size_));
  };
  const int had = int(layer_targets_.size());
  if (part.width > layered_.width || part.height > layered_.height || count > had) {
    layered_.width = enough(layered_.width, part.width);
    layered_.height = enough(layered_.height, part.height);
    layer_targets_.clear();
    layers_ = {};
    layers_ =
        gl::make_depth_layers(gl_, kFormat, layered_.width, layered_.height, std::max(had, count));
    for (int layer = 0; layer < std::max(had, count); ++layer)
      layer_targets_.push_back(gl::make_layer_framebuffer(gl_, layers_.id(), layer));
  }
  // They end where the map does, or within it.
  layered_.x = std::clamp(part.x, 0, size_ - layered_.width);
  layered_.y = std::clamp(part.y, 0, size_ - layered_.height);
}

void ShadowMap::keep_layer(int layer) const {
  gl_.CopyImageSubData(map_.id(), GL_TEXTURE_2D, 0, layered_.x, layered_.y, 0, layers_.id(),
                       GL_TEXTURE_2D_ARRAY, 0, 0, 0, layer, layered_.width, layered_.height, 1);
}

Eigen::Vector4f ShadowMap::on_layers() const {
  const auto size = float(size_), width = float(layered_.width), height = float(layered_.height);
  return {size / width, size / height, -float(layered_.x) / width, -float(layered_.y) / height};
}

void ShadowMap::save(const picture::Rect& part) {
  if (!saved_) saved_ = gl::make_texture(gl_, kFormat, size_, size_);
  copy(map_.id(), saved_.id(), part);
}

void ShadowMap::restore(const picture::Rect& part) const {
  copy(saved_.id(), map_.id(), part);
}

void ShadowMap::copy(GLuint from, GLuint to, const picture::Rect& part) const {
  if (part.empty()) return;
  gl_.CopyImageSubData(from, GL_TEXTURE_2D, 0, part.x, part.y, 0, to, GL_TEXTURE_2D, 0, part.x,
                       part.y, 0, part.width, part.height, 1);
}

namespace {

Eigen::AlignedBox3f around(const Places& places, const std::uint32_t* corner) {
  Eigen::AlignedBox3f box(places[corner[0]]);
  return box.extend(places[corner[1]]).extend(places[corner[2]]);
}

/// Whether a triangle overlaps an upright square, seen along z, if their boxes do: no side of it
/// parts them.
bool meets(const std::array<Eigen::Vector2f, 3>& triangle, const Eigen::Vector2f& centre,
           float half) {
  for (std::size_t k = 0; k < 3; ++k) {
    const Eigen::Vector2f side = triangle[(k + 1) % 3] - triangle[k];
    const Eigen::Vector2f across(-side.y(), side.x());
    const float width = across.dot(triangle[(k + 2) % 3] - triangle[k]);
    const float at = across.dot(centre - triangle[k]), extent = half * across.lpNorm<1>();
    if (at + extent < std::min(width, 0.0f) || at - extent > std::max(width, 0.0f)) return false;
  }
  return true;
}

}  // namespace

void ShadowCover::start(const Eigen::Matrix4f& light_projection, float filter, float penumbra) {
  projection_ = light_projection;
  filter_ = filter;
  penumbra_ = penumbra;
  nearest_.assign(kCells * kCells, std::numeric_limits<float>::infinity());
  covered_.setEmpty();
}

void ShadowCover::project(const Places& places, Places& projected) const {
  const Eigen::Matrix3f m = projection_.topLeftCorner<3, 3>();
  const Eigen::Vector3f t = projection_.topRightCorner<3, 1>();
  projected.clear();
  for (const Eigen::Vector3f& p : places) projected.emplace_back(m * p + t);
}

void ShadowCover::add(std::span<const std::uint32_t> triangles, std::span<const Places> times) {
  if (triangles.empty()) return;
  projected_.resize(std::max(projected_.size(), times.size()));
  for (std::size_t i = 0; i < times.size(); ++i) project(times[i], projected_[i]);
  const auto cell = [](float at) {  // the first one of what is no number
    return at > 0 ? int(std::min(at * kCells, float(kCells - 1))) : 0;
  };
  for (std::size_t i = 0; i < triangles.size(); i += 3) {
    Eigen::AlignedBox3f box;
    for (std::size_t k = 0; k < times.size(); ++k) box.extend(around(projected_[k], &triangles[i]));
    covered_.extend(box);
    for (int y = cell(box.min().y()); y <= cell(box.max().y()); ++y)
      for (int x = cell(box.min().x()); x <= cell(box.max().x()); ++x) {
        float& nearest = nearest_[std::size_t(y * kCells + x)];
        nearest = std::min(nearest, box.min().z());
      }
  }
}

bool ShadowCover::hides(const Places& projected, const std::uint32_t* corner) const {
  const Eigen::AlignedBox3f triangle = around(projected, corner);
  const float filter =
      filter_ + penumbra_ * std::max(triangle.max().z() - covered_.min().z(), 0.0f);
  const float margin = filter + 1.0f / kCells;
  if ((triangle.max().head<2>().array() + margin < covered_.min().head<2>().array()).any() ||
      (triangle.min().head<2>().array() - margin > covered_.max().head<2>().array()).any() ||
      triangle.max().z() <= covered_.min().z())
    return false;
  const Eigen::Array2f low = (triangle.min().head<2>().array() - filter) * float(kCells);
  const Eigen::Array2f high = (triangle.max().head<2>().array() + filter) * float(kCells);
  // So written that what is no number is not hidden.
  if (!(high >= 0).all() || !(low < float(kCells)).all()) return false;
  const Eigen::Array2i first = low.max(0.0f).cast<int>();
  const Eigen::Array2i last = high.min(float(kCells - 1)).cast<int>();
  const std::array sides{Eigen::Vector2f(projected[corner[0]].head<2>()),
                         Eigen::Vector2f(projected[corner[1]].head<2>()),
                         Eigen::Vector2f(projected[corner[2]].head<2>())};
  for (int y = first.y(); y <= last.y(); ++y)
    for (int x = first.x(); x <= last.x(); ++x) {
      if (nearest_[std::size_t(y * kCells + x)] >= triangle.max().z()) continue;
      const Eigen::Vector2f centre((float(x) + 0.5f) / kCells, (float(y) + 0.5f) / kCells);
      if (meets(sides, centre, 0.5f / kCells + filter)) return true;
    }
  return false;
}

Eigen::AlignedBox3f ShadowCover::find(std::span<const std::uint32_t> triangles,
                                      const Places& places,
                                      std::span<const Eigen::AlignedBox3f> boxes,
                                      std::vector<std::uint32_t>& indices) {
  projected_.resize(std::max<std::size_t>(projected_.size(), 1));
  project(places, projected_[0]);
  indices.clear();
  Eigen::AlignedBox3f found;
  for (std::size_t i = 0; i < triangles.size(); i += 3) {
    const std::uint32_t* corner = &triangles[i];
    const bool hidden = hides(projected_[0], corner);
    if (!hidden && boxes.empty()) continue;
    const Eigen::AlignedBox3f box = around(places, corner);
    if (!hidden && std::ranges::none_of(boxes, [&](const auto& b) { return b.intersects(box); }))
      continue;
    indices.insert(indices.end(), corner, corner + 3);
    found.extend(box);
  }
  return found;
}

namespace {

constexpr int kSize = 2048;  // texels; 6 mm of a room of 12 m
constexpr int kBlock = 16;   // texels of a span: penumbras are narrower
constexpr int kBlocks = kSize / kBlock;

using Span = Eigen::Vector2f;  // least and greatest depth

/// The span of each block, and then of it and its neighbours.
std::vector<Span> spans_of(const std::vector<float>& depths) {
  std::vector<Span> own(std::size_t(kBlocks * kBlocks), Span(1, 0)), wide = own;
  const auto add = [](Span& span, float least, float greatest) {
    span = {std::min(span.x(), least), std::max(span.y(), greatest)};
  };
  for (int y = 0; y < kSize; ++y)
    for (int x = 0; x < kSize; ++x) {
      const float depth = depths[std::size_t(y) * kSize + std::size_t(x)];
      add(own[std::size_t(y / kBlock * kBlocks + x / kBlock)], depth, depth);
    }
  for (int y = 0; y < kBlocks; ++y)
    for (int x = 0; x < kBlocks; ++x)
      for (int j = std::max(y - 1, 0); j <= std::min(y + 1, kBlocks - 1); ++j)
        for (int i = std::max(x - 1, 0); i <= std::min(x + 1, kBlocks - 1); ++i) {
          const Span& near = own[std::size_t(j * kBlocks + i)];
          add(wide[std::size_t(y * kBlocks + x)], near.x(), near.y());
        }
  return wide;
}

/// A matrix as a constant of GLSL.
std::string glsl(const Eigen::Matrix4f& m) {
  return fmt::format("mat4({:.9g})", fmt::join(m.data(), m.data() + 16, ", "));
}

}  // namespace

SceneryShadow::SceneryShadow(const gl::Gl& gl, const scenes::Light& light,
                             std::span<Drawable> things)
    : gl_(gl), projection_(Eigen::Matrix4f::Zero()) {
  const Eigen::AlignedBox3d room = box_around(things);
  if (!light.scenery_casts || room.isEmpty()) return;
  projection_ = light_map(light.direction, room, kSize).projection;
  depths_ = gl::make_texture(gl, GL_DEPTH_COMPONENT32F, kSize, kSize);
  plainly_ = gl::make_depth_sampler(gl);
  const gl::GlObject target = gl::make_framebuffer(gl, 0, depths_.id());
  const gl::Program program(gl,
                            fmt::format("const mat4 light_projection = {};\n", glsl(projection_)),
                            gl::shaders::depth_vertex, gl::shaders::depth_fragment);
  gl.BindFramebuffer(GL_FRAMEBUFFER, target.id());
  gl.Viewport(0, 0, kSize, kSize);
  gl.Enable(GL_DEPTH_TEST);
  gl.DepthMask(GL_TRUE);
  gl.DepthFunc(GL_LESS);
  gl.Enable(GL_CULL_FACE);
  gl.CullFace(GL_FRONT);
  gl.Disable(GL_BLEND);
  gl.Disable(GL_SCISSOR_TEST);
  gl.Clear(GL_DEPTH_BUFFER_BIT);
  program.use();
  program.set("model", Eigen::Matrix4f(Eigen::Matrix4f::Identity()));
  for (const Drawable& thing : things) thing.draw();
  std::vector<float> depths(std::size_t(kSize) * kSize);
  gl.PixelStorei(GL_PACK_ROW_LENGTH, kSize);
  gl.ReadPixels(0, 0, kSize, kSize, GL_DEPTH_COMPONENT, GL_FLOAT, depths.data());
  const std::vector<Span> spans = spans_of(depths);
  spans_ = gl::make_texture(gl, GL_RG32F, kBlocks, kBlocks);
  gl.TextureParameteri(spans_.id(), GL_TEXTURE_MAG_FILTER, GL_NEAREST);
  gl.TextureParameteri(spans_.id(), GL_TEXTURE_MIN_FILTER, GL_NEAREST);
  gl.TextureSubImage2D(spans_.id(), 0, 0, 0, kBlocks, kBlocks, GL_RG, GL_FLOAT, spans.data());
}

std::string SceneryShadow::constants() const {
  std::string text = fmt::format("#define CASTING {:d}\n", bool(depths_));
  if (depths_)
    text += fmt::format("const mat4 SCENERY_MAP = {};\n#define SCENERY_PENUMBRA {:.9g}\n",
                        glsl(projection_), penumbra(projection_));
  return text + gl::shaders::past_scenery;
}

void SceneryShadow::bind() const {
  if (!depths_) return;
  gl_.BindTextureUnit(5, depths_.id());
  gl_.BindSampler(5, plainly_.id());
  gl_.BindTextureUnit(6, spans_.id());
}

}  // namespace taut::draw
