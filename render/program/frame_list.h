// Which frames of a clip are asked for.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace taut::program {

/// Reads "A-B,C": frame numbers and inclusive ranges, each below `total`; rising, without repeats.
/// No text means every frame. Throws Misuse.
std::vector<int> frame_list(const std::optional<std::string>& text, int total);

/// Reads "WxH". Throws Misuse.
std::pair<int, int> picture_size(const std::string& text);

}  // namespace taut::program
