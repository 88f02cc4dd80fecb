#include "render/gl/shaders.h"

namespace taut::gl::shaders {

// Cook-Torrance with GGX (Walter et al. 2007), visibility by Schlick's k = a/2, Schlick's Fresnel;
// the environment's part of the specular by the fit of Karis 2014 ("Physically based shading on
// mobile"). Ambient light: spherical harmonics of Ramamoorthi and Hanrahan 2001.
const char* const surface_fragment = R"(
in vec3 world_position, world_normal, rest_position, tint, shadow_position;
#if FINE
in vec2 soft_light;
#endif
layout(location = 0) out vec4 encoded;
uniform vec3 base_color;
uniform float base_roughness, metallic, opacity;
uniform int grain_axis;
uniform float grain_scale;
uniform float paid_out, length_ratio;  // of a rope: how its material moves past what is drawn
layout(binding = 0) uniform sampler2DShadow shadow_map;
layout(binding = 1) uniform sampler2D noise;
layout(binding = 4) uniform sampler2D casters;  // the shadow map's depths
#if SHADE == 2
layout(binding = 3) uniform sampler2D backdrop;  // its light, blurred by the lens
#endif
#if BATHED
in vec3 bath;
#endif
#if TEXTURED
in vec2 uv;
layout(binding = 7) uniform sampler2D picture;
#endif

// What lies beyond the map's depths is lit where nothing is in them.
float shadow_depth() { return min(shadow_position.z, 1.0); }

#if LAYERED
layout(binding = 8) uniform sampler2DArray layers;  // depths of a part of the map, at several instants

vec4 depths_at(vec2 place, int layer) {
  return textureGather(layers, vec3(place * on_layers.xy + on_layers.zw, layer));
}
// Beyond them nothing casts.
bool is_on_layers() {
  return all(greaterThan(shadow_position.xy, layered.xy)) && all(lessThan(shadow_position.xy, layered.zw));
}
#else
vec4 depths_at(vec2 place, int layer) { return textureGather(casters, place); }
#endif

#if SHADE == 1 || SHADE == 3
// The light past four texels of the shadow map. A surface that the light grazes is as uneven in the
// map as its depth changes from texel to texel: within 1.5 times that it fades into the shadow.
vec4 lit_past(vec2 corner, float sharpness, int layer) {
  vec4 depths = depths_at(corner * (1.0 / SHADOW_SIZE), layer);
  return clamp((depths - shadow_depth()) * sharpness + 1, 0, 1);
}

// 1 over the depth in which a surface fades.
float sharpness_of(float nl) {
  float cosine = max(nl, 0.12);
  return 1 / (texel_depth * (0.5 + 1.5 * sqrt(1 - cosine * cosine) / cosine));
}
#endif

// One bilinear comparison with the shadow map.
float lit_at(vec2 place, float sharpness, int layer) {
  vec2 at = place * SHADOW_SIZE - 0.5, corner = floor(at), f = at - corner;
#if SHADE == 3
  vec4 lit = lit_past(corner + 1, sharpness, layer);
#elif LAYERED
  vec4 lit = vec4(greaterThanEqual(depths_at((corner + 1) * (1.0 / SHADOW_SIZE), layer), vec4(shadow_depth())));
#else
  vec4 lit = textureGather(shadow_map, (corner + 1) * (1.0 / SHADOW_SIZE), shadow_depth());
#endif
  return dot(lit, vec4((1 - f.x) * f.y, f.x * f.y, f.x * (1 - f.y), (1 - f.x) * (1 - f.y)));
}

#if SHADE == 2
// What hides the light is how far away (Fernando 2005)? Then the light's disc from there, each of
// its points from another place of the pixel.
float disc_visibility(bool needed, vec2 across, vec2 down, int layer) {
  float widest = max(penumbra * shadow_depth(), LEAST_PENUMBRA);
  vec2 found = vec2(0);  // depths, and how many
  for (int i = needed ? 0 : 5; i < 5; ++i) {
    vec2 corner = i < 4 ? vec2(i & 1, i >> 1) * 1.4 - 0.7 : vec2(0);
    vec4 depths = depths_at(shadow_position.xy + widest * corner +
                                0.5 * (corner.x * across + corner.y * down), layer);
    vec4 near = vec4(lessThan(depths, vec4(shadow_depth())));
    found += vec2(dot(near, depths), dot(near, vec4(1)));
  }
  int count = found.y > 0 && found.y < 20 ? 16 : 0;  // none of the disc is hidden, or all
  float away = shadow_depth() - found.x / max(found.y, 1), sum = found.y > 0 ? 0 : 16;
  float radius = max(penumbra * away, LEAST_PENUMBRA);
  vec2 direction = vec2(1, 0);
  for (int i = 0; i < count; ++i) {
    direction = vec2(-0.73736888 * direction.x - 0.67549029 * direction.y,
                     0.67549029 * direction.x - 0.73736888 * direction.y);
    vec2 within = fract(0.5 + float(i) * vec2(0.75487767, 0.56984029)) - 0.5;  // Roberts 2018
    sum += lit_at(shadow_position.xy + radius * sqrt((float(i) + 0.5) / 16) * direction +
                      within.x * across + within.y * down, 0, layer);
  }
  return sum * (1.0 / 16.0);
}
#endif

// 1 where the key light reaches. Loops rather than conditions, as software rasterisers skip only
// loops: nothing is looked up where the surface faces away or lies outside the map.
float key_visibility(bool needed, float nl) {
#if SHADE == 0
  return 1;
#else
  vec2 inside = abs(shadow_position.xy - 0.5);
  needed = needed && max(inside.x, inside.y) < 0.5;
#if SHADE == 3 && LAYERED
  // The mean of the layers is smooth.
  float sum = 0, sharpness = sharpness_of(nl), beyond = shadow_position.z - pivot;
  needed = needed && is_on_layers();
  for (int k = needed ? first_layer : end_layer; k < end_layer; ++k)
    sum += lit_at(shadow_position.xy + beyond * moved_light[k].xy, sharpness, k);
  return needed ? sum / float(end_layer - first_layer) : 1;
#elif SHADE == 3
  // The mean of the exposures is smooth.
  float sum = 1;
  for (int i = needed ? 0 : 1; i < 1; ++i) sum = lit_at(shadow_position.xy, sharpness_of(nl), -1);
  return sum;
#elif SHADE == 1
  // 3x3 comparisons, from four gathers of 2x2 texels: as wide as penumbras from a quarter metre away.
  vec2 at = shadow_position.xy * SHADOW_SIZE - 0.5;
  vec2 corner = floor(at), f = at - corner;
  float sum = 0, sharpness = sharpness_of(nl);
  int i = needed ? 0 : 4;
  if (i == 4) sum = 9;
  for (; i < 4; ++i) {
    vec2 place = vec2(i & 1, i >> 1) * 2 - 1;
    vec4 lit = lit_past(corner + place + 1, sharpness, -1);
    vec2 w = vec2(place.x < 0 ? 1 - f.x : 1, place.x > 0 ? f.x : 1);
    vec2 h = vec2(place.y < 0 ? 1 - f.y : 1, place.y > 0 ? f.y : 1);
    sum += dot(lit, vec4(w.x * h.y, w.y * h.y, w.y * h.x, w.x * h.x));
  }
  return sum * (1.0 / 9.0);
#else
  vec2 across = dFdx(shadow_position.xy), down = dFdy(shadow_position.xy);
#if LAYERED
  needed = needed && is_on_layers();
  float sum = 0;
  for (int k = needed ? first_layer : end_layer; k < end_layer; ++k)
    sum += disc_visibility(needed, across, down, k);
  return needed ? sum / float(end_layer - first_layer) : 1;
#else
  return disc_visibility(needed, across, down, -1);
#endif
#endif
#endif
}

vec3 ambient_light(vec3 n) {
  return AMBIENT[0] + AMBIENT[1] * n.y + AMBIENT[2] * n.z + AMBIENT[3] * n.x +
         AMBIENT[4] * (n.x * n.y) + AMBIENT[5] * (n.y * n.z) +
         AMBIENT[6] * (3.0 * n.z * n.z - 1.0) + AMBIENT[7] * (n.x * n.z) +
         AMBIENT[8] * (n.x * n.x - n.y * n.y);
}

#if MIRROR
layout(binding = 2) uniform samplerCube mirror;

// What a mirror of that roughness sees: the room's walls, where its box has them (Lagarde and
// Zanuttini 2012).
vec3 environment(vec3 r, float roughness) {
  vec3 far = max((ROOM_HIGH - world_position) / r, (ROOM_LOW - world_position) / r);
  float way = max(min(min(far.x, far.y), far.z), 0);
  return textureLod(mirror, world_position + way * r - MIDDLE, roughness * ROUGHEST).rgb;
}
#else
// What a mirror of that roughness sees: ground below, sky above, walls in the key light between
// them; softer where rougher.
vec3 environment(vec3 r, float roughness) {
  float blur = 0.15 + 0.85 * roughness;
  float wall = max(1 - abs(r.y - 0.25) / (0.25 + blur), 0);
  return mix(GROUND, SKY, smoothstep(-blur, blur, r.y)) + 0.16 * wall * wall * LIGHT_COLOR;
}
#endif

// Coordinates across the surface, in the rest position, on the plane that it faces most.
vec2 facing(vec3 p, vec3 n) {
  vec3 a = abs(n);
  return a.x > a.y && a.x > a.z ? p.yz : a.y > a.z ? p.xz : p.xy;
}

// A wave of that many turns: parabolas, within 6% of the sine and a fifth of its time.
float wave(float turns) {
  float x = 2 * (turns - floor(turns)) - 1;
  return -4 * x * (1 - abs(x));
}

// By how much a wave rises in one turn.
float wave_slope(float turns) {
  return 32 * abs(turns - floor(turns) - 0.5) - 8;
}

#if SURFACE == 2
// The directions across and along the threads of a cloth in the rest position, on the plane that it
// faces most.
void threads_at(vec3 faces, out vec3 across, out vec3 along) {
  across = vec3(1, 0, 0);
  along = vec3(0, 1, 0);
  vec3 a = abs(faces);
  if (a.x > a.y && a.x > a.z) across = vec3(0, 0, 1);
  else if (a.y > a.z) along = vec3(0, 0, 1);
}
#endif

// A normal tilted by heights over the surface (Mikkelsen 2010), given how these change along the
// rest position: differences of heights between pixels would show the pixels' grid.
vec3 bumped(vec3 n, vec3 rest_slope) {
  vec3 x = dFdx(world_position), y = dFdy(world_position);
  vec3 across = cross(y, n), along = cross(n, x);
  float area = dot(x, across);
  vec3 slope = sign(area) * (dot(rest_slope, dFdx(rest_position)) * across +
                             dot(rest_slope, dFdy(rest_position)) * along);
  // No steeper than threads are at rest, where skinning crumples the surface.
  slope *= min(1, 0.4 * abs(area) * inversesqrt(max(dot(slope, slope), 1e-30)));
  return normalize(abs(area) * n - slope);
}

// A film's curve: a long shoulder, and a toe (Narkowicz 2015, his fit of the curve of ACES, with
// 0.06 for 0.03, so that shadows lose half as much).
vec3 tone_mapped(vec3 radiance) {
  vec3 x = radiance * EXPOSURE;
  return min(x * (2.51 * x + 0.06) / (x * (2.43 * x + 0.59) + 0.14), 1.0);
}

// Square root of the tone-mapped light: nearly even steps to the eye, cheap to undo before
// averaging.
vec3 encode(vec3 radiance) {
  return sqrt(tone_mapped(radiance));
}

#if OUTPUT == 0
void main() {
  encoded = vec4(0.5, 0.5, 0.5, opacity);
}
#else
void main() {
  vec3 n = normalize(world_normal);
  // Beyond a triangle's edge, where a pixel's middle may lie, what varies over it may be below 0.
  vec3 albedo = base_color * max(tint, 0);
#if TEXTURED
  albedo *= texture(picture, uv).rgb;
#endif
  float roughness = base_roughness;
  vec3 wrap = vec3(0);   // how far diffuse light reaches round the terminator

#if SURFACE == 1  // wood: streaks along the grain
  vec3 p = grain_axis == 0 ? rest_position.yzx : grain_axis == 1 ? rest_position.zxy : rest_position;
  p *= grain_scale;
  vec2 streaks = texture(noise, vec2(p.z * 0.9, (p.x + 0.6 * p.y) * 9.0)).rg;
  albedo *= 0.70 + 0.42 * streaks.r + 0.18 * streaks.g;
  roughness += 0.25 * (0.5 - streaks.r);
#elif SURFACE == 2  // cloth: a weave that fades before it aliases, and a soft sheen
  vec3 across, along;
  threads_at(cross(dFdx(rest_position), dFdy(rest_position)), across, along);
  // Uneven yarn and dye: streaks along the threads.
  vec2 yarn = texture(noise, vec2(dot(rest_position, across) * 13, dot(rest_position, along) * 2.6)).rg;
  albedo *= 0.90 + 0.08 * yarn.r + 0.12 * yarn.g;
  // Grains of rice in staggered rows, as quilted cotton has; on small things the finer ribs of twill.
  vec3 first = grain_scale > 1 ? 290 * (across + along) : 320 * across;
  vec3 second = grain_scale > 1 ? 90 * (across - along) : 230 * along;
  vec2 turns = vec2(dot(rest_position, first), dot(rest_position, second));
  vec2 width = fwidth(turns);
  float fade = clamp(1.3 - 5.0 * max(width.x, width.y), 0, 1);
  float wave_first = wave(turns.x), wave_second = wave(turns.y);
  float grain = fade * wave_first * wave_second;
  albedo *= 1 + 0.16 * grain;
  float high = fade * (grain_scale > 1 ? 0.00007 : 0.00006);  // m
  vec3 rises = high * (wave_slope(turns.x) * wave_second * first +
                       wave_first * wave_slope(turns.y) * second);
  // Creases that no vertex has room for, some 4 cm apart, and 19 mm high for 1 of the noise.
  vec2 place = vec2(dot(rest_position, across), dot(rest_position, along)) * vec2(2.3, 1.5);
  vec2 slope = (255.0 * texture(noise, place).ba - 128.0) / 510.0 * (256.0 / 4.0);
  rises += 0.019 * (slope.x * 2.3 * across + slope.y * 1.5 * along);
  n = bumped(n, rises);
  wrap = vec3(0.15);
#elif SURFACE == 3  // skin: light that went in comes out redder past the terminator
  wrap = vec3(0.17, 0.11, 0.09);
  vec2 place = facing(rest_position, n);
  float pores = texture(noise, place * 31.0).g;  // 1 to 4 mm, blotches 10 times as large
  albedo *= mix(vec3(0.90, 0.84, 0.80), vec3(1.06, 1.10, 1.12), texture(noise, place * 6.0).r);
  albedo *= 0.94 + 0.12 * pores;
  roughness += 0.30 * (pores - 0.5);
#elif SURFACE == 4  // rope: three strands; rest_position is (turn, metres along, radius)
  float along = length_ratio * rest_position.y - paid_out;
  float strand = abs(sin(3.14159 * (3.0 * rest_position.x + along / (7.0 * rest_position.z))));
  albedo *= 0.45 + 0.55 * sqrt(strand);
  wrap = vec3(0.1);
#elif SURFACE == 5  // paper: daylight from behind comes through, and shows the fibres
  albedo *= 0.94 + 0.12 * texture(noise, facing(rest_position, n) * vec2(1.1, 1.7)).g;
  vec3 through = 0.70 * albedo * DAYLIGHT;
#elif SURFACE == 6  // turned wood: the rings of a tree whose pith lies beside it, and pores
  vec3 p = grain_axis == 0 ? rest_position.yzx : grain_axis == 1 ? rest_position.zxy : rest_position;
  vec2 pores = texture(noise, vec2(p.z * 5.0, (p.x + 0.6 * p.y) * 90.0)).rg;
  vec2 bent = texture(noise, vec2(p.z * 1.3, 0.37)).rg - 0.5;
  float rings = length(p.xy - vec2(0.031, 0.012) + 0.007 * bent) / 0.0024;  // 2.4 mm apart
  float late = smoothstep(0.25, 0.95, fract(rings)) * (1 - smoothstep(0.95, 1.0, fract(rings)));
  float told = clamp(1.4 - 2.0 * fwidth(rings), 0, 1);  // before they alias
  albedo *= (1.24 - 0.78 * mix(0.36, late, told)) * (0.70 + 0.60 * pores.r);
#endif

  vec3 v = normalize(eye.xyz - world_position), l = TO_LIGHT;
  float nl = dot(n, l), nv = dot(n, v);
  nv = max(nv, max(0.5 * fwidth(nv), 1e-3));  // a pixel at the rim sees more than the rim
  vec3 h = normalize(l + v);
  float nh = max(dot(n, h), 0), vh = max(dot(v, h), 0);
  float lit = max(nl, 0);

  float a = roughness * roughness, a2 = a * a, k = 0.5 * a;
  float d = nh * nh * (a2 - 1) + 1;
  float lobe = 0.25 * a2 / (d * d * ((lit * (1 - k) + k) * (nv * (1 - k) + k)));
#if SURFACE == 2
  vec3 f0 = vec3(0.036);  // fibres hide some of each other's gloss
#else
  vec3 f0 = mix(vec3(0.04), albedo, metallic);
#endif
  float c = 1 - vh, c2 = c * c;
  vec3 fresnel = f0 + (1 - f0) * (c2 * c2 * c);

  // Units: a white Lambert surface that faces the key light has the radiance LIGHT_COLOR.
  vec3 diffuse = albedo * (1 - metallic);
#if SURFACE == 2 || SURFACE == 3 || SURFACE == 4
  vec3 diffuse_lit = max((nl + wrap) * (1 / ((1 + wrap) * (1 + wrap))), 0);
#else
  vec3 diffuse_lit = vec3(lit);
#endif
  bool needed = max(diffuse_lit.r, diffuse_lit.b) > 0;
#if FINE
  float open_sky = soft_light.x;
#else
  float open_sky = past_scenery(world_position);
#endif
  float seen = open_sky * key_visibility(needed, dot(normalize(world_normal), l));
  vec3 radiance = LIGHT_COLOR * seen * (diffuse * diffuse_lit + lobe * fresnel * lit);

  vec4 r = roughness * vec4(-1, -0.0275, -0.572, 0.022) + vec4(1, 0.0425, 1.04, -0.04);
  float grazing = min(r.x * r.x, exp2(-9.28 * nv)) * r.x + r.y;
  vec2 fit = vec2(-1.04, 1.04) * grazing + r.zw;
#if BATHED
  vec3 ambient = max(bath, 0);
#else
  vec3 ambient = ambient_light(n);
#endif
#if OUTPUT == 2 || (MIRROR && !GLOSSY && BATHED)
  vec3 mirrored = ambient;
#elif MIRROR && !GLOSSY
  vec3 mirrored = max(ambient_light(reflect(-v, n)), 0);
#else
  vec3 mirrored = environment(reflect(-v, n), base_roughness);
#endif
  vec3 gloss = max(f0 * fit.x + fit.y, 0) * mirrored;
  vec3 ambient_part = diffuse * ambient + gloss;
#if SURFACE == 2
  // Fuzz: fibres that stand off catch light at the edges, in the dye's colour.
  float rim = 1 - nv;
  vec3 fuzz = 0.45 * rim * rim * rim * sqrt(max(albedo, 0));
  ambient_part += fuzz * mirrored;  // through them, too, where the surface is seen at its edge
  radiance += LIGHT_COLOR * seen * lit * fuzz;
#endif
#if FINE
  float open = soft_light.y;
#else
  float open = contact_light(world_position, n);
#endif
#if SHADE == 2
  vec3 unshaded = LIGHT_COLOR * open_sky * (diffuse * diffuse_lit + lobe * fresnel * lit) + ambient_part;
#endif
#if SHADE == 2 && MIRROR && GLOSSY
  // Cloth is darker than what it hides.
  ambient_part -= 0.6 * hidden_by_legs(world_position, reflect(-v, n), roughness) * gloss;
#endif
#if !BATHED
  // A light behind what moves, above it, is seen at its edges.
  float behind = 1 - nv, behind2 = behind * behind;
  ambient_part += RIM * (diffuse + f0) * (behind2 * behind2 * max(0.5 + 0.5 * n.y, 0));
#endif
  radiance += open * ambient_part;
#if SURFACE == 5
  radiance += through;
#endif
#if OUTPUT == 2
  encoded = vec4(radiance, 1);
#elif SHADE == 2
  // A shadow takes its share of the light that the pixel's samples and the lens have mixed.
#if SURFACE == 5
  unshaded += through;
#endif
  vec3 mixed = texelFetch(backdrop, ivec2(gl_FragCoord.xy), 0).rgb;
  vec3 share = min((tone_mapped(radiance) + 1e-6) / (tone_mapped(unshaded) + 1e-6), 1.0);
  encoded = vec4(sqrt(mixed * share), opacity);
#else
  encoded = vec4(encode(radiance), opacity);
#endif
}
#endif
)";

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
