// The GLSL sources. The head of each says what it computes.
#pragma once

namespace taut::gl::shaders {

/// What every surface needs to know of a frame; goes before the shaders of surfaces and depth.
extern const char* const frame_block;

/// The share of the key light that comes past the scenery to a place, where CASTING is 1.
extern const char* const past_scenery;

/// What is left of ambient and mirrored light near the frame's capsules.
extern const char* const contact;

/// Lit surfaces. Defines: SURFACE (a Surface), SHADE (a Shade), OUTPUT (an Output), GLOSSY (1: it
/// mirrors the room where MIRROR is 1), BATHED (1: ambient light comes with the vertices), FINE (1:
/// light that changes slowly is found at the vertices), TEXTURED (1: a picture multiplies the
/// colour).
extern const char* const surface_vertex;
extern const char* const surface_fragment;

/// Depth as the key light sees it.
extern const char* const depth_vertex;
extern const char* const depth_fragment;

/// One triangle that covers the picture, and the passes that finish it.
extern const char* const cover_vertex;
/// pixel_light(pixel), the light of a pixel's samples. Defines: SAMPLES, and PLACES, where they are
/// from the pixel's centre.
extern const char* const pixel_light;
/// A share of that light.
extern const char* const gather_fragment;
/// Light to all samples of its pixel.
extern const char* const put_fragment;
/// The light of a pixel's samples, or with SAMPLES 0 light as it was gathered, to dithered
/// 8-bit sRGB, top row first. Define: SAMPLES.
extern const char* const finish_fragment;

}  // namespace taut::gl::shaders
