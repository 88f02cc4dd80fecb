#include "render/gl/shaders.h"

namespace taut::gl::shaders {

// What every surface needs to know of a frame; FrameBlock in surfaces.h mirrors it.
const char* const frame_block = R"(
layout(std140, binding = 0) uniform Frame {
  mat4 view_projection;
  mat4 light_projection;   // world to [0,1]^3 of the shadow map
  vec4 eye;                // xyz; w: offset along the normal before the shadow's look-up, m
  vec4 capsule_from[12];    // xyz; w: radius
  vec4 capsule_to[12];      // xyz; w: 1/length^2
  float penumbra;          // half of it, in widths of the map, for each of its depths
  float texel_depth;       // a texel's width, in depths of the map
  // What moves stands in layers, at several instants: a part of the map. The light comes from
  // another point of its disc in each.
  float pivot;             // the depth at which that moves nothing
  int first_layer, end_layer;
  vec4 moved_light[8];     // xy: how far it moves a look-up, for each depth beyond the pivot
  vec4 layered;            // xy: the part's corner, zw: its opposite one, in widths of the map
  vec4 on_layers;          // a place on the map to one on the layers: xy times, zw more
};
)";

const char* const surface_vertex = R"(
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 2) in vec3 rest;
layout(location = 3) in vec3 color;
uniform mat4 model;
invariant gl_Position;
out vec3 world_position, world_normal, rest_position, tint, shadow_position;
#if BATHED
layout(location = 4) in vec3 light;
out vec3 bath;
#endif
#if TEXTURED
layout(location = 5) in vec2 place_on_picture;
out vec2 uv;
#endif
#if FINE
out vec2 soft_light;  // past the scenery, past capsules
#endif

void main() {
  world_position = (model * vec4(position, 1)).xyz;
  world_normal = mat3(model) * normal;
  rest_position = rest;
  tint = color;
#if BATHED
  bath = light;
#endif
  shadow_position = (light_projection * vec4(world_position + eye.w * world_normal, 1)).xyz;
#if TEXTURED
  uv = place_on_picture;
#endif
#if FINE
  soft_light = vec2(past_scenery(world_position), contact_light(world_position, normalize(world_normal)));
#endif
  gl_Position = view_projection * vec4(world_position, 1);
})";

}  // namespace taut::gl::shaders
