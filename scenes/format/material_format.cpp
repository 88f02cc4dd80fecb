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

std::vector<KeyFormat> cord_keys() {
  return {
      {.name = "restitution",
       .meaning = "Coefficient of restitution when it goes taut.",
       .minimum = 0,
       .maximum = 1},
      {.name = "look",
       .type = Type::choice,
       .meaning = "How it is drawn.",
       .choices = {"chain", "rope", "cord"}},
      not_negative("radius",
                   "Of its particles, as beads that touch obstacles; default: half of the "
                   "diameter as drawn.",
                   "m"),
      {.name = "contact",
       .type = Type::choice,
       .meaning = "What touches obstacles: its beads, or the links between them as well, as "
                  "capsules.",
       .choices = {"beads", "links"}},
      {.name = "touches_itself",
       .type = Type::flag,
       .meaning = "Whether its links touch each other, as capsules of its radius, and those of "
                  "its copies or cords; default: false."},
      friction("Coulomb's coefficient where it touches itself, of what slides; default: 0."),
      static_friction(),
      positive("diameter", "As drawn: of the rope or cord, or across a link of the chain.", "m"),
      color("color", "Linear colour."),
      positive("axial_stiffness", "EA: tension per strain; default: links are rigid.", "N"),
      not_negative("axial_damping", "Tension per rate of strain, of links that stretch.", "N s"),
      not_negative("bending_stiffness", "EI: moment per curvature; default: it bends freely.",
                   "N m^2"),
      not_negative("bending_damping", "Moment per rate of curvature.", "N m^2 s"),
      table("material", "Gives mass, EA, EI and GJ of a solid round rod instead.",
            material_format()),
      table("drag", "Coefficients of the air's drag on it, of its diameter.", drag_format())};
}

std::vector<Alternatives> cord_alternatives() {
  return {{{"mass", "material"}},
          {{"axial_stiffness", "material"}, false},
          {{"bending_stiffness", "material"}, false}};
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
