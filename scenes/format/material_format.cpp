#include "scenes/format/format_keys.h"

namespace taut::scenes {

using namespace format_keys;

const TableFormat& material_format() {
  static const TableFormat format{
      {needed(positive("youngs_modulus", "Stress per strain, in stretch and in bending.", "Pa")),
       needed(positive("diameter", "Of the rod.", "m")),
       needed(positive("density", "Of what it is made of.", "kg/m^3")),
       {.name = "poissons_ratio",
        .meaning = "Of it, by which GJ follows from EI; default: 0.3.",
        .minimum = -1,
        .maximum = 0.5,
        .above = true}}};
  return format;
}

const TableFormat& drag_format() {
  static const TableFormat format{
      {not_negative("across", "For flow across it; 1.2 for a round rope.", "1"),
       not_negative("along", "For flow along it; 0.01 to 0.1, more for a rough rope.", "1")}};
  return format;
}

const TableFormat& air_format() {
  static const TableFormat format{
      {not_negative("density", "Default: 1.225.", "kg/m^3"),
       vector("wind", "Velocity of the air, the same everywhere; default: [0, 0, 0].", "m/s"),
       {.name = "file",
        .type = Type::file,
        .meaning = "A CSV file with the columns t,x,y,z: the wind (m/s) over time (s), smooth "
                   "between its rows and constant beyond them."}},
      {{{"wind", "file"}, false}}};
  return format;
}

}  // namespace taut::scenes
