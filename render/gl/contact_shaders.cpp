#include "render/gl/shaders.h"

namespace taut::gl::shaders {

// What capsules near a surface take of its light. Ambient light: the cosine-weighted solid angle of
// the nearest sphere on each capsule, less what it is where its reach ends. The counts of capsules
// are constants, so that loops are unrolled: software rasterisers fetch what a variable indexes
// lane by lane.
const char* const contact = R"(
float contact_light(vec3 p, vec3 n) {
  float light = 1;
#if SHADE > 0
#if SHADE == 2
  const int first = 0, end = FEET;
#else
  const int first = LEGS, end = CAPSULES;
#endif
  for (int i = first; i < end; ++i) {
    vec3 axis = capsule_to[i].xyz - capsule_from[i].xyz, from = p - capsule_from[i].xyz;
    vec3 d = axis * clamp(dot(from, axis) * capsule_to[i].w, 0, 1) - from;
    float distance2 = dot(d, d);
    float r2 = capsule_from[i].w * capsule_from[i].w;
    float sphere = max(r2 / distance2 - 1.0 / (CONTACT_RANGE * CONTACT_RANGE), 0);
    light *= 1 - 0.9 * min(max(dot(n, d), 0) * inversesqrt(distance2) * sphere, 1);
  }
#endif
#if SHADE == 2
  return light;
#else
  // Cloth that arms hide from the room gets a part of its light back from them.
  const float thrown_back = 0.35;
  return mix(thrown_back, 1, light);
#endif
}

#if SHADE == 2 && MIRROR && GLOSSY
// The share of what a glossy floor mirrors along r that feet and shins hide: none beyond the reach of
// the feet, where the scenery stays as it is.
float hidden_by_legs(vec3 p, vec3 r, float roughness) {
  float near = 0, open = 1;
  for (int i = 0; i < LEGS; ++i) {
    vec3 axis = capsule_to[i].xyz - capsule_from[i].xyz, from = p - capsule_from[i].xyz;
    float radius = capsule_from[i].w, along = dot(from, axis), ahead = dot(from, r);
    vec3 d = axis * clamp(along * capsule_to[i].w, 0, 1) - from;
    if (i < FEET) near = max(near, 2 - 2 * length(d) / (0.9 * CONTACT_RANGE * radius));
    // Where the ray comes nearest to the axis.
    float b = dot(r, axis), across = max(1 / capsule_to[i].w - b * b, 1e-6);
    float s = clamp((along - b * ahead) / across, 0, 1), t = max(s * b - ahead, 0);
    float miss = length(from + t * r - s * axis);
    float blur = 0.01 + 0.9 * roughness * t;  // half of the lobe's width
    open *= 1 - clamp(0.5 + (radius - miss) / (2 * blur), 0, 1) * min(1.5 * radius / blur, 1.0);
  }
  return (1 - open) * clamp(near, 0, 1);
}
#endif
)";

}  // namespace taut::gl::shaders
