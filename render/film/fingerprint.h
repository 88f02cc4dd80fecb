// Hashes of everything that a frame is made from, by which finished frames are known again.
#pragma once

#include <cstdint>
#include <span>

#include "render/draw/frame_state.h"
#include "scenes/scene/stage.h"

namespace taut::film {

/// Of the program itself (its executable file).
std::uint64_t program_fingerprint();
/// Of what never moves: models, lights, looks, captions.
std::uint64_t fingerprint(const scenes::Stage& stage);
/// Of what moves while the shutter is open, bit for bit.
std::uint64_t fingerprint(std::span<const draw::FrameState> shutter);

}  // namespace taut::film
