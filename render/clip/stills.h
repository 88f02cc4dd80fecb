// Single pictures of a clip: a contact sheet, a poster.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "render/film/film.h"
#include "render/options/outputs.h"

namespace taut::clips {

struct Stills {
  bool contact_sheet = false;
  std::optional<double> every;   // s of the clip between a sheet's pictures; else captions' middles
  std::optional<double> poster;  // s of the clip
  std::string poster_file;       // empty: poster.png
  bool transparent = false;      // the poster

  bool any() const { return contact_sheet || every || poster; }
};

/// Writes them into the folder `out`, the poster under its name where it has one, and returns their
/// names, one a line. Throws Misuse where the clip has nothing of the kind, and CannotWrite.
std::string make_stills(const Stills& stills, const scenes::Scene& scene, film::Film& film,
                        const std::filesystem::path& out, const options::Provenance& provenance);

}  // namespace taut::clips
