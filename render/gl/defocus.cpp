#include "render/gl/defocus.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>

#include "render/gl/shaders.h"

namespace taut::gl {
namespace {

constexpr int kLevels = 5;

// The light of each pixel; of its circles that of the nearest sample, so that the edge of a thing
// in focus is in focus, too.
const char* const kCollect = R"(
layout(binding = 0) uniform sampler2D drawn;
layout(binding = 1) uniform sampler2DMS depths;
layout(location = 0) out vec4 light;
uniform float nearest, farthest;
void main() {
  ivec2 pixel = ivec2(gl_FragCoord.xy);
  float depth = 1;
  for (int i = 0; i < SAMPLES; ++i) depth = min(depth, texelFetch(depths, pixel, i).r);
  light = vec4(texelFetch(drawn, pixel, 0).rgb, mix(nearest, farthest, depth));
})";

// Points of a sunflower over the pixel's own circle: each a texel of the level whose texels are as
// far apart as the points. HALF: pixels of half the size, and what they blur by themselves,
// premultiplied; the others take wide circles from there.
const char* const kGather = R"(
layout(binding = 0) uniform sampler2D sharp;
layout(location = 0) out vec4 blurred;
uniform vec4 part;  // its low corner, its high corner

vec4 gathered(vec4 own, vec2 middle, float radius, int count) {
  float radius2 = radius * radius;
  float level = clamp(floor(0.5 * log2(3.1416 * radius2 / float(count)) + 0.5), float(HALF), LEVELS - 1);
  float border = exp2(level);
  vec2 low = part.xy + border, high = part.zw - border;
  vec4 sum = vec4(own.rgb, 1) * (1 / radius2);
  vec2 direction = vec2(1, 0);
  for (int i = 0; i < count; ++i) {
    float away = radius * sqrt((float(i) + 0.5) / float(count));
    direction = vec2(-0.73736888 * direction.x - 0.67549029 * direction.y,
                     0.67549029 * direction.x - 0.73736888 * direction.y);
    vec2 at = clamp(middle + away * direction, low, high);
    vec4 there = textureLod(sharp, at * (1 / SIZE), level);
    // What lies farther spreads over this no more than this is blurred.
    float circle = abs(there.a);
    if (there.a > own.a) circle = min(circle, radius);
    float share = clamp(circle - away + 0.5, 0, 1) / max(circle * circle, 0.25);
    sum += vec4(there.rgb, 1) * share;
  }
  return vec4(sum.rgb / sum.a, 1);
}

#if HALF
void main() {
  vec4 own = texelFetch(sharp, ivec2(gl_FragCoord.xy), 1);
  float radius = abs(own.a);
  int count = radius > NARROW ? int(min(6 + 0.25 * radius * radius, MOST)) : 0;
  blurred = vec4(0);
  if (count > 0) blurred = gathered(own, gl_FragCoord.xy * (SIZE / HALF_SIZE), radius, count);
}
#else
layout(binding = 1) uniform sampler2D wide;
void main() {
  vec4 own = texelFetch(sharp, ivec2(gl_FragCoord.xy), 0);
  float radius = abs(own.a);
  vec4 far = radius > NARROW ? texture(wide, clamp(gl_FragCoord.xy, part.xy + 2, part.zw - 2) * (1 / SIZE)) : vec4(0);
  float share = far.a > 0.1 ? clamp((radius - NARROW) / (WIDE - NARROW), 0, 1) : 0;
  int count = radius > LEAST && share < 1 ? int(min(8 + 0.9 * radius * radius, MOST)) : 0;
  vec4 near = vec4(own.rgb, 1);
  if (count > 0) near = gathered(own, gl_FragCoord.xy, radius, count);
  if (share > 0) near.rgb = mix(near.rgb, far.rgb / far.a, share);
  blurred = vec4(near.rgb, 1);
}
#endif
)";

int mipmaps(int width, int height) {
  return std::min(kLevels, int(std::bit_width(unsigned(std::max(width, height)))));
}

int half_of(int size) {
  return std::max(size / 2, 1);
}

/// Circles of radii up to LEAST px are sharp, and from WIDE px on they are made of pixels of half
/// the size; to be sure, between NARROW and WIDE of both.
std::string constants(int width, int height, bool half) {
  return fmt::format(
      "#define HALF {:d}\n#define LEAST 0.5\n#define NARROW 1.5\n#define WIDE 2.5\n#define MOST "
      "24\n#define LEVELS {}.0\n#define SIZE vec2({}, {})\n#define HALF_SIZE vec2({}, {})\n",
      half, mipmaps(width, height), width, height, half_of(width), half_of(height));
}

}  // namespace

Defocus::Defocus(const Gl& gl, int width, int height, int samples)
    : gl_(gl),
      width_(width),
      height_(height),
      sharp_(make_texture(gl, GL_RGBA16F, width, height, 0, mipmaps(width, height))),
      sharp_target_(make_framebuffer(gl, sharp_.id(), 0)),
      wide_(make_texture(gl, GL_RGBA16F, half_of(width), half_of(height))),
      wide_target_(make_framebuffer(gl, wide_.id(), 0)),
      no_vertices_(make_vertex_array(gl)),
      collect_(gl, fmt::format("#define SAMPLES {}\n", samples), shaders::cover_vertex, kCollect),
      gather_wide_(gl, constants(width, height, true), shaders::cover_vertex, kGather),
      gather_(gl, constants(width, height, false), shaders::cover_vertex, kGather) {
  gl.TextureParameteri(sharp_.id(), GL_TEXTURE_MIN_FILTER, GL_LINEAR_MIPMAP_NEAREST);
}

void Defocus::apply(std::span<const DefocusedView> views, GLuint light, GLuint depth,
                    GLuint target) {
  gl_.Disable(GL_DEPTH_TEST);
  gl_.Disable(GL_BLEND);
  gl_.BindTextureUnit(0, light);
  gl_.BindTextureUnit(1, depth);
  const auto collect = [&](const DefocusedView& view) {
    collect_.set("nearest", view.confusion.nearest);
    collect_.set("farthest", view.confusion.farthest);
    cover(view.part, collect_, sharp_target_.id());
  };
  if (views.size() > 1) collect({{0, 0, width_, height_}, {}});  // between the views
  for (const DefocusedView& view : views) collect(view);
  gl_.GenerateTextureMipmap(sharp_.id());
  gl_.BindTextureUnit(0, sharp_.id());
  gl_.BindTextureUnit(1, wide_.id());
  for (const auto& [part, confusion] : views) {
    const Eigen::Vector4f corners(float(part.x), float(part.y), float(part.x + part.width),
                                  float(part.top()));
    gather_wide_.set("part", corners);
    gather_.set("part", corners);
    cover({part.x / 2, part.y / 2, (part.width + 1) / 2, (part.height + 1) / 2}, gather_wide_,
          wide_target_.id());
    cover(part, gather_, target);
  }
}

void Defocus::cover(const picture::Rect& part, const Program& program, GLuint target) const {
  gl_.BindFramebuffer(GL_FRAMEBUFFER, target);
  gl_.Viewport(0, 0, width_, height_);
  gl_.Enable(GL_SCISSOR_TEST);
  gl_.Scissor(part.x, part.y, part.width, part.height);
  gl_.BindVertexArray(no_vertices_.id());
  program.use();
  gl_.DrawArrays(GL_TRIANGLES, 0, 3);
  gl_.Disable(GL_SCISSOR_TEST);
}

}  // namespace taut::gl
