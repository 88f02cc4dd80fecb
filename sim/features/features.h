// The features of worlds as data: which a world uses and where, and which a method follows.
#pragma once

#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace taut {

struct World;
struct Timeline;

/// What a world may have beside rigid links that bend freely. Messages and tables show features in
/// this order; a feature that implies another stands behind it.
enum class Feature : std::uint8_t {
  // Connectors with sections (sim/material)
  stretch,
  bending,
  bending_damping,
  rest_curvature,
  twist,
  air,
  taper,
  clamp,             // at a place whose motion is prescribed
  turning_clamp,     // Hold::turn
  clamp_on_body,     // at a free body
  material_on_body,  // a connector with sections holds a free body
  applied_force,     // Connector::applied_force
  strings,           // links that only pull (Connector::pulls)
  string_rebound,    // strings that rebound when they go taut (Connector::restitution)
  // Contact (sim/contact)
  obstacle,
  moving_obstacle,
  links_touch,      // links touch obstacles as capsules
  body_contact,     // free bodies touch obstacles
  body_pairs,       // free bodies touch each other
  bead_pairs,       // beads touch free bodies
  connector_pairs,  // links of connectors touch each other
  self_contact,     // links of one connector do
  friction,
  restitution,
  // Connectors that depend on each other
  joint,
  loop,           // a connector that is joined to itself
  joint_in_flow,  // at a particle past which a winch or a pulley moves rope
  winch,
  pulley,
  sheave,  // a pulley with inertia
  pulley_friction,
  span,   // massless
  hinge,  // a connector of length 0 at a free body
  free_body,
  // Interventions
  pin,
  cut,
};
inline constexpr std::size_t kFeatureCount = 36;

/// A set of features.
class Features {
 public:
  constexpr Features() = default;
  constexpr Features(Feature one) : bits_(std::uint64_t{1} << static_cast<int>(one)) {}
  constexpr Features(std::initializer_list<Feature> list) {
    for (const Feature one : list) bits_ |= Features(one).bits_;
  }
  static constexpr Features all() {
    Features all;
    all.bits_ = (std::uint64_t{1} << kFeatureCount) - 1;
    return all;
  }

  constexpr bool has(Feature one) const { return (bits_ & Features(one).bits_) != 0; }
  constexpr bool empty() const { return bits_ == 0; }
  constexpr bool operator==(const Features&) const = default;
  constexpr Features& operator|=(Features other) { return *this = *this | other; }
  friend constexpr Features operator|(Features a, Features b) { return of(a.bits_ | b.bits_); }
  friend constexpr Features operator&(Features a, Features b) { return of(a.bits_ & b.bits_); }
  friend constexpr Features operator-(Features a, Features b) { return of(a.bits_ & ~b.bits_); }

 private:
  static constexpr Features of(std::uint64_t bits) {
    Features some;
    some.bits_ = bits;
    return some;
  }
  std::uint64_t bits_ = 0;
};

// Groups for declarations.
inline constexpr Features kMaterialFeatures{
    Feature::stretch,        Feature::bending,         Feature::bending_damping,
    Feature::rest_curvature, Feature::twist,           Feature::air,
    Feature::taper,          Feature::clamp,           Feature::turning_clamp,
    Feature::clamp_on_body,  Feature::material_on_body};
inline constexpr Features kConnectorContact{Feature::connector_pairs, Feature::self_contact};
inline constexpr Features kContactFeatures{
    Feature::obstacle,   Feature::moving_obstacle, Feature::links_touch,     Feature::body_contact,
    Feature::body_pairs, Feature::bead_pairs,      Feature::connector_pairs, Feature::self_contact,
    Feature::friction,   Feature::restitution};
inline constexpr Features kJointFeatures{Feature::joint, Feature::loop};
inline constexpr Features kPulleyFeatures{Feature::pulley, Feature::sheave,
                                          Feature::pulley_friction};
/// What belongs to places along a rope, and would flow with it through a winch or over a pulley.
inline constexpr Features kUnlikeReels{Feature::twist, Feature::bending_damping,
                                       Feature::rest_curvature, Feature::taper};
inline constexpr Features kReelFeatures = Feature::winch | kPulleyFeatures;
inline constexpr Features kPlainFeatures{Feature::hinge, Feature::free_body, Feature::pin,
                                         Feature::cut};

/// The feature in messages and tables: "bending damping".
std::string_view name(Feature feature);

/// A use of a feature: an element of one of the lists of a World or, for pins and cuts that are yet
/// to come, of a Timeline.
struct Use {
  enum class At {
    connector,
    body,
    obstacle,
    joint,
    pulley,
    body_pair,
    bead_pair,
    connector_pair,
    pin,
    cut
  };
  Feature feature = {};
  At at = At::connector;
  std::size_t index = 0;
};

/// The features that a world uses. Allocates nothing.
Features features(const World& world);
/// The same with the pins and cuts of a timeline.
Features features(const World& world, const Timeline& timeline);
/// Every use of a feature, list by list of the world; `timeline` may be null.
std::vector<Use> uses(const World& world, const Timeline* timeline = nullptr);
/// The element that uses a feature, in words: "connector rope", "bodies a and b", "pins[2]".
std::string where(const World& world, const Use& use);

/// Features that a method does not follow together: each of `one` with each of `other`.
struct Apart {
  enum class Within {
    world,      // wherever they are
    connector,  // on one connector; on different ones it follows both
  };
  Features one, other;
  std::string_view reason = {};  // where it is a physical one: a clause for a message
  Within within = Within::world;
};

/// The features that a method or a command follows: a declaration.
struct Abilities {
  Features follows;
  std::vector<Apart> apart = {};

  /// The entry of `apart` with this pair, or null.
  const Apart* find_apart(Feature a, Feature b) const;
};

/// The reason for which a world is refused: a feature that is not followed, or two that are not
/// followed together.
struct Refusal {
  Use one;
  std::optional<Use> other = {};
  std::string_view reason = {};
};

/// The first reason to refuse a world, or none. Allocates nothing where every feature of the world
/// is followed and no two of them stand in `apart`.
std::optional<Refusal> find_refusal(const Abilities& abilities, const World& world,
                                    const Timeline* timeline = nullptr);

/// A refusal as the rest of a sentence about who refuses: "does not follow bending (connector rope)
/// together with obstacles (obstacle floor)".
std::string words(const World& world, const Refusal& refusal);

}  // namespace taut
