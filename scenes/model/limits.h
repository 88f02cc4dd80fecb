// The limits of a model: beyond them a file is refused before it is taken apart.
#pragma once

#include <cstddef>

namespace taut::scenes::model_limits {

constexpr std::size_t bytes = 64u << 20;      // of a file, and of all buffers together
constexpr std::size_t files = 1024;           // that it names
constexpr std::size_t all_bytes = 2 * bytes;  // of those files together
constexpr std::size_t meshes = 4096;  // pieces of one material: primitives, groups, uses of them
constexpr std::size_t nodes = 65536;
constexpr std::size_t depth = 128;  // of the tree of nodes
constexpr std::size_t bones = 256;
constexpr std::size_t vertices = 4u << 20;  // over all pieces, also those that share data
constexpr std::size_t indices = 24u << 20;
constexpr std::size_t keys = 16u << 20;  // numbers of all animations
// Of the process that reads it. The largest of the above take about half of it.
constexpr std::size_t memory = 2048u << 20;
// Of that process's reply: 8 million vertices with their indices, and the pictures.
constexpr std::size_t reply = 1024u << 20;
constexpr std::size_t pixels = 64u << 20;  // of all pictures

}  // namespace taut::scenes::model_limits
