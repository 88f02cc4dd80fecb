// The smallest scene that still fails.
#pragma once

#include <functional>
#include <string>

namespace taut::drawn {

/// Leaves out tables and lines of the scene, and halves its numbers, as long as `fails` says that
/// what is left still does.
std::string shrunk(std::string scene, const std::function<bool(const std::string&)>& fails);

}  // namespace taut::drawn
