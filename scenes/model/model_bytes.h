// A model, or the files that it names, as bytes between two processes of one program.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "scenes/model/model.h"
#include "scenes/model/named_files.h"

namespace taut::scenes {

std::string to_bytes(const Model& model);

/// The model of which to_bytes() made them, to the bit. Nothing where they are of no model: cut
/// short, too long, beyond the limits, with an index of nothing, or with a number that is not
/// finite.
std::optional<Model> model_of_bytes(std::string_view bytes);

std::string to_bytes(const std::vector<NamedFile>& files);
/// The same; nothing where they are cut short or too long.
std::optional<std::vector<NamedFile>> named_files_of_bytes(std::string_view bytes);

}  // namespace taut::scenes
