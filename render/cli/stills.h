// Single pictures of a clip: a contact sheet, a poster.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "render/film.h"

namespace taut::cli {

struct Stills {
  bool contact_sheet = false;
  std::optional<double> every;   // s of the clip between a sheet's pictures; else captions' middles
  std::optional<double> poster;  // s of the clip

  bool any() const { return contact_sheet || every || poster; }
};

/// Writes them into the folder `out`, and returns their names, one a line. Throws Misuse where the
/// clip has nothing of the kind, and CannotWrite.
std::string make_stills(const Stills& stills, const Scene& scene, Film& film,
                        const std::filesystem::path& out);

}  // namespace taut::cli
