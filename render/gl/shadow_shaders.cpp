#include "render/gl/shaders.h"

namespace taut::gl::shaders {

const char* const depth_vertex = R"(
layout(location = 0) in vec3 position;
uniform mat4 model;
void main() {
  gl_Position = vec4((light_projection * (model * vec4(position, 1))).xyz * 2 - 1, 1);
})";

const char* const depth_fragment = "void main() {}";

const char* const past_scenery = R"(
#if CASTING
layout(binding = 5) uniform sampler2D scenery_depths;
layout(binding = 6) uniform sampler2D scenery_spans;  // the least and the greatest depth near by

float past_scenery(vec3 position) {
  vec3 place = (SCENERY_MAP * vec4(position, 1)).xyz;
  vec2 span = textureLod(scenery_spans, place.xy, 0).rg;
  bool mixed = place.z > span.x && place.z <= span.y;
  float lit = place.z > span.y ? 0 : 1;
  // What hides the light is how far away (Fernando 2005)? Then the light's disc from there.
  const float texel = 1.0 / textureSize(scenery_depths, 0).x;
  float widest = max(SCENERY_PENUMBRA * (place.z - span.x), 2 * texel);
  vec2 found = vec2(0);  // depths, and how many
  for (int i = mixed ? 0 : 5; i < 5; ++i) {
    vec2 at = place.xy + (i < 4 ? widest * (vec2(i & 1, i >> 1) * 1.4 - 0.7) : vec2(0));
    vec4 depths = textureGather(scenery_depths, at);
    vec4 near = vec4(lessThan(depths, vec4(place.z)));
    found += vec2(dot(near, depths), dot(near, vec4(1)));
  }
  if (found.y >= 20) lit = 0;
  bool partly = found.y > 0 && found.y < 20;
  float radius = max(SCENERY_PENUMBRA * (place.z - found.x / max(found.y, 1)), 2 * texel), sum = 0;
  vec2 direction = vec2(1, 0);
  for (int i = partly ? 0 : 24; i < 24; ++i) {
    direction = vec2(-0.73736888 * direction.x - 0.67549029 * direction.y,
                     0.67549029 * direction.x - 0.73736888 * direction.y);
    vec2 at = (place.xy + radius * sqrt((float(i) + 0.5) / 24) * direction) / texel - 0.5;
    vec2 corner = floor(at), f = at - corner;
    vec4 open = vec4(greaterThanEqual(textureGather(scenery_depths, (corner + 1) * texel),
                                      vec4(place.z)));
    sum += mix(mix(open.w, open.z, f.x), mix(open.x, open.y, f.x), f.y);
  }
  return partly ? sum * (1.0 / 24.0) : lit;
}
#else
float past_scenery(vec3 position) { return 1; }
#endif
)";

}  // namespace taut::gl::shaders
