// The fabrics of a character's clothes: which of its bones are cloth that hangs, and of what.
#pragma once

#include <string_view>

namespace taut::scenes {

/// What chains of bones are made of: strips of cloth that hang from a limb side by side.
struct Fabric {
  std::string_view name;     // of the bones, after the side: SkirtFrontA1, LeftCuffB1
  double mass;               // kg/m, of a strip
  double bending_stiffness;  // EI of a strip, N m^2
  double width;              // m, of a strip, that the air meets
  double band_stiffness;     // EA of the cloth between one strip and the next, N; 0: none
  std::string_view touches;  // the bones' names, after the side: of the limb that it hangs on if it
                             // has that name, else of all that begin so
  double stand_off;          // m, from the middle of the cloth to what it touches
};

/// A bone's name without its side.
std::string_view without_side(std::string_view bone);

/// The fabric of the bone of that name; null: it is not of cloth that hangs.
const Fabric* fabric_of(std::string_view bone);

}  // namespace taut::scenes
