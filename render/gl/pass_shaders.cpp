#include "render/gl/shaders.h"

namespace taut::gl::shaders {

const char* const cover_vertex = R"(
void main() {
  gl_Position = vec4(vec2(gl_VertexID & 1, gl_VertexID >> 1) * 4 - 1, 0, 1);
})";

const char* const pixel_light = R"(
layout(binding = 0) uniform sampler2DMS samples;
uniform float smooth_from;  // how far the samples of a pixel differ where an edge runs through it

// The light of a pixel's samples. Where an edge runs through it, those around it count as well, by
// a tent two pixels wide: four samples alone make four steps of an edge.
vec3 pixel_light(ivec2 pixel) {
  vec3 light = vec3(0), least = vec3(1), most = vec3(0);
  for (int i = 0; i < SAMPLES; ++i) {
    vec3 s = texelFetch(samples, pixel, i).rgb;
    light += s * s;
    least = min(least, s);
    most = max(most, s);
  }
  // Software rasterisers skip only loops.
  bool edge = any(greaterThan(most - least, vec3(smooth_from)));
  ivec2 end = textureSize(samples) - 1;
  vec3 smoothed = vec3(0);
  for (int i = edge ? 0 : SAMPLES; i < SAMPLES; ++i) {
    // This sample of the four pixels in which it lies under the tent.
    ivec2 side = -ivec2(sign(PLACES[i]));
    vec2 far = abs(PLACES[i]);
    for (int k = 0; k < 4; ++k) {
      ivec2 away = ivec2(k & 1, k >> 1);
      vec2 weight = mix(1 - far, far, vec2(away));
      vec3 s = texelFetch(samples, clamp(pixel + away * side, ivec2(0), end), i).rgb;
      smoothed += weight.x * weight.y * s * s;
    }
  }
  return (edge ? smoothed : light) * (1.0 / SAMPLES);
}
)";

const char* const gather_fragment = R"(
layout(location = 0) out vec4 mean;
uniform float share;
uniform ivec2 corner;  // of the part of the picture that the target holds
void main() {
  mean = vec4(share * pixel_light(corner + ivec2(gl_FragCoord.xy)), 1);
})";

const char* const put_fragment = R"(
layout(binding = 0) uniform sampler2D light;
layout(location = 0) out vec4 encoded;
void main() {
  encoded = vec4(sqrt(texelFetch(light, ivec2(gl_FragCoord.xy), 0).rgb), 1);
})";

const char* const finish_fragment = R"(
#if SAMPLES == 0
layout(binding = 0) uniform sampler2D gathered;
uniform ivec2 corner;  // of the part of the picture that it holds
#endif
layout(location = 0) out vec4 color;
uniform int height;
void main() {
  ivec2 pixel = ivec2(gl_FragCoord.x, height - 1 - int(gl_FragCoord.y));
#if SAMPLES > 0
  vec3 light = pixel_light(pixel);
#else
  vec3 light = texelFetch(gathered, pixel - corner, 0).rgb;
#endif
  // Roots instead of the power of 1/2.4, within a quarter of a step of the 8-bit scale.
  vec3 root2 = sqrt(light), root4 = sqrt(root2), root8 = sqrt(root4);
  vec3 power = 0.662002687 * root2 + 0.684122060 * root4 - 0.323583601 * root8 - 0.0225411470 * light;
  vec3 srgb = mix(12.92 * light, power, step(0.0031308, light));
  // Interleaved gradient noise (Jimenez 2014), one step of the 8-bit scale wide.
  float noise = fract(52.9829189 * fract(dot(gl_FragCoord.xy, vec2(0.06711056, 0.00583715))));
  color = vec4(srgb + (noise - 0.5) / 255.0, 1);
})";

}  // namespace taut::gl::shaders
