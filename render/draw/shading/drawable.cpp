#include "render/draw/shading/drawable.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cctype>

namespace taut::draw {
namespace {

constexpr float kFine = 0.05f;  // m

std::vector<mesh::RestVertex> rest_of(const scenes::Mesh& mesh) {
  std::vector<mesh::RestVertex> rest;
  rest.reserve(mesh.vertices.size());
  for (const scenes::Vertex& v : mesh.vertices)
    rest.push_back({Eigen::Vector3f(v.position.data()), Eigen::Vector3f(v.color.data())});
  return rest;
}

/// The mean of the triangles' longest edges, by area, m; 0 without any area.
float mean_length(const RestShape& shape) {
  float area = 0, sum = 0;
  const std::vector<std::uint32_t>& of = shape.triangles();
  for (std::size_t i = 0; i < of.size(); i += 3) {
    const auto edge = [&](std::size_t from, std::size_t to) -> Eigen::Vector3f {
      return shape.rest()[of[i + to]].rest - shape.rest()[of[i + from]].rest;
    };
    const Eigen::Vector3f a = edge(0, 1), b = edge(1, 2), c = edge(2, 0);
    const float twice = a.cross(b).norm();
    area += twice;
    sum += twice * std::max({a.norm(), b.norm(), c.norm()});
  }
  return area > 0 ? sum / area : 0;
}

}  // namespace

Surface surface_named(std::string_view material) {
  // The words of the name: dark and wood of "DarkWood_02". "hardwood" is wood, "cloak" is no oak.
  std::vector<std::string> parts(1);
  for (std::size_t i = 0; i < material.size(); ++i) {
    const auto c = static_cast<unsigned char>(material[i]);
    const bool begins = std::isupper(c) && i > 0 && std::islower((unsigned char)material[i - 1]);
    if (begins || !std::isalpha(c)) parts.emplace_back();
    if (std::isalpha(c)) parts.back() += char(std::tolower(c));
  }
  const auto has = [&](std::initializer_list<const char*> words) {
    return std::ranges::any_of(words, [&](const std::string_view word) {
      return std::ranges::any_of(parts, [&](const std::string& part) {
        return part == word || (word.size() > 3 && part.ends_with(word)) ||
               (part.ends_with('s') && part.size() == word.size() + 1 && part.starts_with(word));
      });
    });
  };
  if (has({"oak"})) return Surface::turned;
  if (has({"wood", "floor", "plank", "beam"})) return Surface::wood;
  if (has({"cloth", "gi", "belt", "band", "collar", "tabi", "trouser", "fabric", "cotton"}))
    return Surface::cloth;
  if (has({"skin"})) return Surface::skin;
  if (has({"paper"})) return Surface::paper;
  return Surface::plain;
}

RestShape::RestShape(const gl::Gl& gl, std::vector<std::uint32_t> triangles,
                     std::vector<mesh::RestVertex> rest)
    : triangles_(std::move(triangles)),
      rest_(std::move(rest)),
      rest_buffer_(gl::make_buffer(gl)),
      moving_(gl::make_buffer(gl)),
      indices_(gl::make_buffer(gl)),
      some_indices_(gl::make_buffer(gl)) {
  gl::upload(gl, indices_, std::span<const std::uint32_t>(triangles_), GL_STATIC_DRAW);
  gl::upload(gl, rest_buffer_, std::span<const mesh::RestVertex>(rest_), GL_STATIC_DRAW);
}

Drawable::Drawable(const gl::Gl& gl, std::shared_ptr<const RestShape> shape,
                   const scenes::Material& material, Surface surface)
    : gl_(&gl), shape_(std::move(shape)), material_(material), surface_(surface) {
  make_arrays();
  Eigen::AlignedBox3f box;
  for (const mesh::RestVertex& v : shape_->rest()) box.extend(v.rest);
  fine_ = surface_ != Surface::rope && mean_length(*shape_) < kFine;
  if (!box.isEmpty()) grain_scale_ = box.sizes().maxCoeff(&grain_axis_) < 0.7f ? 5 : 1;
}

Drawable::Drawable(const gl::Gl& gl, const scenes::Mesh& mesh, const scenes::Material& material,
                   std::shared_ptr<const gl::GlObject> texture)
    : Drawable(gl, std::make_shared<RestShape>(gl, mesh.indices, rest_of(mesh)), material,
               surface_named(material.name)) {
  if (texture) {
    std::vector<std::array<float, 2>> places;
    for (const scenes::Vertex& v : mesh.vertices) places.push_back(v.uv);
    texture_ = std::move(texture);
    places_ = gl::make_buffer(gl);
    gl::upload(gl, places_, std::span<const std::array<float, 2>>(places), GL_STATIC_DRAW);
    make_arrays();
  }
  std::vector<mesh::MovingVertex> vertices;
  vertices.reserve(mesh.vertices.size());
  for (const scenes::Vertex& v : mesh.vertices)
    vertices.push_back({Eigen::Vector3f(v.position.data()), Eigen::Vector3f(v.normal.data())});
  move(vertices);
}

void Drawable::move(std::span<const mesh::MovingVertex> vertices) {
  gl::upload(*gl_, shape_->moving_, vertices, GL_DYNAMIC_DRAW);
  box_.setEmpty();
  positions_.clear();
  positions_.reserve(vertices.size());
  for (const mesh::MovingVertex& v : vertices) {
    positions_.push_back(v.position);
    box_.extend(v.position);
  }
}

void Drawable::follow(Vertices vertices) {
  follows_ = std::move(vertices);
  std::vector<mesh::MovingVertex>& at = shape_->vertices_;
  follows_(at);
  box_.setEmpty();
  for (const mesh::MovingVertex& v : at) box_.extend(v.position);
  shape_->loaded_ = nullptr;
  if (shape_.use_count() > 1) return;  // others load theirs before this is drawn
  gl::upload(*gl_, shape_->moving_, std::span<const mesh::MovingVertex>(at), GL_DYNAMIC_DRAW);
  shape_->loaded_ = this;
}

/// Has the shape's room hold the vertices of this.
void Drawable::load() const {
  if (!follows_ || shape_->loaded_ == this) return;
  std::vector<mesh::MovingVertex>& at = shape_->vertices_;
  follows_(at);
  gl::upload(*gl_, shape_->moving_, std::span<const mesh::MovingVertex>(at), GL_DYNAMIC_DRAW);
  shape_->loaded_ = this;
  // A software rasteriser keeps what it was given, half a kilobyte a triangle, until it has drawn
  // it.
  constexpr std::size_t kWaiting = 3 << 13;  // indices
  shape_->waiting_ += triangles().size();
  if (shape_->waiting_ < kWaiting) return;
  gl_->Finish();
  shape_->waiting_ = 0;
}

void Drawable::find_positions(std::vector<Eigen::Vector3f>& positions) const {
  if (!follows_) {
    positions = positions_;
    return;
  }
  follows_(shape_->vertices_);
  positions.clear();
  for (const mesh::MovingVertex& v : shape_->vertices_) positions.push_back(v.position);
}

void Drawable::bathe(std::span<const Eigen::Vector3f> light) {
  light_ = gl::make_buffer(*gl_);
  gl::upload(*gl_, light_, light, GL_STATIC_DRAW);
  make_arrays();
}

/// Arrays are never changed: NVIDIA's driver overlooks changes to an array that it has drawn.
void Drawable::make_arrays() {
  all_ = make_array(shape_->indices_);
  some_ = make_array(shape_->some_indices_);
}

gl::GlObject Drawable::make_array(const gl::GlObject& indices) const {
  struct Attribute {
    GLuint location, binding;
    std::size_t offset;
  };
  constexpr Attribute kAttributes[] = {{0, 0, offsetof(mesh::MovingVertex, position)},
                                       {1, 0, offsetof(mesh::MovingVertex, normal)},
                                       {2, 1, offsetof(mesh::RestVertex, rest)},
                                       {3, 1, offsetof(mesh::RestVertex, color)},
                                       {4, 2, 0},
                                       {5, 3, 0}};
  gl::GlObject array = gl::make_vertex_array(*gl_);
  const GLuint id = array.id();
  gl_->VertexArrayElementBuffer(id, indices.id());
  gl_->VertexArrayVertexBuffer(id, 0, shape_->moving_.id(), 0, sizeof(mesh::MovingVertex));
  gl_->VertexArrayVertexBuffer(id, 1, shape_->rest_buffer_.id(), 0, sizeof(mesh::RestVertex));
  if (bathed()) gl_->VertexArrayVertexBuffer(id, 2, light_.id(), 0, sizeof(Eigen::Vector3f));
  if (texture_) gl_->VertexArrayVertexBuffer(id, 3, places_.id(), 0, 2 * sizeof(float));
  for (const auto& [location, binding, offset] : kAttributes) {
    if ((binding == 2 && !bathed()) || (binding == 3 && !texture_)) continue;
    gl_->EnableVertexArrayAttrib(id, location);
    gl_->VertexArrayAttribFormat(id, location, binding == 3 ? 2 : 3, GL_FLOAT, GL_FALSE,
                                 GLuint(offset));
    gl_->VertexArrayAttribBinding(id, location, binding);
  }
  return array;
}

void Drawable::draw(std::span<const std::uint32_t> indices) {
  if (indices.empty()) return;
  load();
  gl::upload(*gl_, shape_->some_indices_, indices, GL_STREAM_DRAW);
  draw(some_, indices.size());
}

void Drawable::draw() const {
  load();
  draw(all_, triangles().size());
}

void Drawable::draw(const gl::GlObject& array, std::size_t indices) const {
  gl_->BindVertexArray(array.id());
  gl_->DrawElements(GL_TRIANGLES, GLsizei(indices), GL_UNSIGNED_INT, nullptr);
}

gl::GlObject make_picture_texture(const gl::Gl& gl, const scenes::Texture& texture) {
  const auto width = int(texture.width), height = int(texture.height);
  const int levels = int(std::bit_width(std::max(texture.width, texture.height)));
  gl::GlObject made = gl::make_texture(gl, GL_SRGB8_ALPHA8, width, height, 0, levels);
  gl.PixelStorei(GL_UNPACK_ALIGNMENT, 1);
  gl.TextureSubImage2D(made.id(), 0, 0, 0, width, height, GL_RGBA, GL_UNSIGNED_BYTE,
                       texture.pixels.data());
  gl.GenerateTextureMipmap(made.id());
  for (const auto& [name, value] : {std::pair(GL_TEXTURE_WRAP_S, texture.wrap_u),
                                    {GL_TEXTURE_WRAP_T, texture.wrap_v},
                                    {GL_TEXTURE_MAG_FILTER, texture.magnify},
                                    {GL_TEXTURE_MIN_FILTER, texture.minify}}) {
    gl.TextureParameteri(made.id(), GLenum(name), GLint(value));
  }
  return made;
}

Eigen::AlignedBox3d box_around(std::span<const Drawable> things) {
  Eigen::AlignedBox3d around;
  for (const Drawable& thing : things)
    if (!thing.box().isEmpty())
      around.extend(
          Eigen::AlignedBox3d(thing.box().min().cast<double>(), thing.box().max().cast<double>()));
  return around;
}

}  // namespace taut::draw
