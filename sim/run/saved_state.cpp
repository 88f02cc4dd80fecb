#include "sim/run/saved_state.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <type_traits>
#include <utility>

#include "sim/motion/hash.h"
#include "sim/run/trajectory.h"

namespace taut {
namespace {

constexpr std::string_view kMagic = "taut state 1\n";
constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

[[noreturn]] void damaged() {
  throw BadState("the state is damaged, expected all bytes as they were saved");
}

template <class Archive, class T>
void visit(Archive& archive, T& value);
template <class Archive>
void visit(Archive& archive, Hold& hold);
template <class Archive>
void visit(Archive& archive, Section& section);
template <class Archive>
void visit(Archive& archive, Connector& connector);
template <class Archive>
void visit(Archive& archive, Joint& joint);

/// Writes values, one after the other.
class Out {
 public:
  Out(const StateParts& parts, std::string& bytes) : parts_(parts), bytes_(bytes) {}

  template <class T>
  void operator()(const T& value) {
    static_assert(std::is_trivially_copyable_v<T>);
    bytes_.append(reinterpret_cast<const char*>(&value), sizeof value);
  }
  void operator()(const Vec3& v) {
    for (const double c : v) (*this)(c);
  }
  void operator()(const Mat3& m) {
    for (const double c : m.reshaped()) (*this)(c);
  }
  void operator()(const Quat& q) {
    for (const double c : q.coeffs()) (*this)(c);
  }
  void operator()(const std::string& text) {
    (*this)(text.size());
    bytes_ += text;
  }
  template <class T>
  void operator()(const std::vector<T>& list) {
    (*this)(list.size());
    for (const T& item : list) visit(*this, const_cast<T&>(item));
  }
  void operator()(const std::shared_ptr<const Path>& path) { index(path, parts_.paths()); }
  void operator()(const std::shared_ptr<const Winch>& winch) { index(winch, parts_.winches()); }
  void operator()(const std::shared_ptr<const AppliedForce>& force) {
    index(force, parts_.forces());
  }

 private:
  template <class Thing>
  void index(const std::shared_ptr<const Thing>& one, const StateParts::List<Thing>& list) {
    const auto found = list.number.find(one.get());
    if (one && found == list.number.end()) {
      throw BadState(
          "a pin is held by a path that neither the world nor the timeline had at the start");
    }
    (*this)(one ? found->second : kNone);
  }

  const StateParts& parts_;
  std::string& bytes_;
};

/// Reads them again.
class In {
 public:
  In(const StateParts& parts, std::string_view bytes) : parts_(parts), bytes_(bytes) {}

  bool done() const { return bytes_.empty(); }

  template <class T>
  void operator()(T& value) {
    static_assert(std::is_trivially_copyable_v<T>);
    if (bytes_.size() < sizeof value) damaged();
    std::memcpy(&value, bytes_.data(), sizeof value);
    bytes_.remove_prefix(sizeof value);
    if constexpr (std::is_floating_point_v<T>) {
      if (std::isnan(value)) damaged();
    }
  }
  void operator()(bool& value) {
    unsigned char byte = 0;
    (*this)(byte);
    value = byte != 0;
  }
  void operator()(Vec3& v) {
    for (double& c : v) finite(c);
  }
  void operator()(Mat3& m) {
    for (double& c : m.reshaped()) finite(c);
  }
  void operator()(Quat& q) {
    for (double& c : q.coeffs()) finite(c);
    if (std::abs(q.norm() - 1) > 1e-3) damaged();
  }
  void operator()(std::string& text) {
    text = std::string(bytes_.substr(0, count(1)));
    bytes_.remove_prefix(text.size());
  }
  template <class T>
  void operator()(std::vector<T>& list) {
    list.resize(count(sizeof(T) > 8 ? 8 : 1));
    for (T& item : list) visit(*this, item);
  }
  void operator()(std::shared_ptr<const Path>& path) { take(path, parts_.paths()); }
  void operator()(std::shared_ptr<const Winch>& winch) { take(winch, parts_.winches()); }
  void operator()(std::shared_ptr<const AppliedForce>& force) { take(force, parts_.forces()); }

 private:
  void finite(double& value) {
    (*this)(value);
    if (!std::isfinite(value)) damaged();
  }
  /// How many items follow, which take so many bytes each at least.
  std::size_t count(std::size_t each) {
    std::size_t found = 0;
    (*this)(found);
    if (found > bytes_.size() / each) damaged();
    return found;
  }
  template <class Thing>
  void take(std::shared_ptr<const Thing>& one, const StateParts::List<Thing>& list) {
    std::uint32_t found = kNone;
    (*this)(found);
    if (found != kNone && found >= list.all.size()) damaged();
    one = found == kNone ? nullptr : list.all[found];
  }

  const StateParts& parts_;
  std::string_view bytes_;
};

// What a state has of each thing, in the order of its bytes.

template <class Archive, class T>
void visit(Archive& archive, T& value) {
  archive(value);
}

template <class Archive>
void visit(Archive& archive, MassProperties& mass) {
  archive(mass.mass);
  archive(mass.centre);
  archive(mass.inertia);
}

template <class Archive>
void visit(Archive& archive, Body& body) {
  visit(archive, body.mass_properties);
  visit(archive, body.bare);
  archive(body.position);
  archive(body.rotation);
  archive(body.velocity);
  archive(body.spin);
}

template <class Archive>
void visit(Archive& archive, PinRecord& pin) {
  archive(pin.number);
  archive(pin.fraction);
  archive(pin.link_rest);
  archive(pin.since);
  archive(pin.topology);
  for (Vec3* v :
       {&pin.position, &pin.velocity, &pin.body_position, &pin.body_velocity, &pin.body_spin}) {
    archive(*v);
  }
}

template <class Archive>
void visit(Archive& archive, Hold& hold) {
  archive(hold.particle);
  archive(hold.to.kind);
  archive(hold.to.point);
  archive(hold.to.path);
  archive(hold.to.body);
  archive(hold.to.approach.lag);
  archive(hold.to.approach.since);
  archive(hold.to.approach.arrival);
  visit(archive, hold.pin);
  archive(hold.clamp);
  archive(hold.turn);
}

template <class Archive>
void visit(Archive& archive, Section& section) {
  for (double* number :
       {&section.axial_stiffness, &section.axial_damping, &section.bending_stiffness,
        &section.bending_damping, &section.twisting_stiffness, &section.twisting_damping,
        &section.rest_twist, &section.diameter}) {
    archive(*number);
  }
  archive(section.rest_curvature);
}

template <class Archive>
void visit(Archive& archive, Connector& connector) {
  archive(connector.name);
  for (double* number :
       {&connector.length, &connector.mass, &connector.restitution, &connector.radius,
        &connector.breaks_at, &connector.drag.across, &connector.drag.along,
        &connector.end_turn.start, &connector.end_turn.since}) {
    archive(*number);
  }
  archive(connector.category);
  archive(connector.links_touch);
  archive(connector.model);
  archive(connector.pulls);
  archive(connector.end_place);
  archive(connector.holds);
  archive(connector.rest);
  archive(connector.particle_mass);
  archive(connector.position);
  archive(connector.velocity);
  archive(connector.sections);
  archive(connector.winch);
  archive(connector.applied_force);
}

template <class Archive>
void visit(Archive& archive, Joint& joint) {
  archive(joint.particles);
}

template <class Archive>
void visit(Archive& archive, Pulley& pulley) {
  archive(pulley.passed);
  archive(pulley.speed);
}

template <class Archive>
void visit(Archive& archive, SavedState& state) {
  World& world = state.world;
  archive(world.time);
  for (Body& body : world.bodies) visit(archive, body);
  for (Pulley& pulley : world.pulleys) visit(archive, pulley);
  archive(world.connectors);
  archive(world.joints);
  archive(world.bead_pairs);
  archive(world.connector_pairs);
  archive(world.pins);
  archive(world.end_places);
  archive(world.topology);
  archive(state.next);
  archive(state.pins);
  archive(state.cuts);
  archive(state.links_rotation);
}

bool is_finite(double value) {
  return std::isfinite(value);
}

/// Whether a connector's lists fit each other and its holds fit the world.
bool is_sound(const World& world, const Connector& connector) {
  const std::size_t n = connector.particles();
  const bool fits = n >= 2 && connector.velocity.size() == n &&
                    connector.particle_mass.size() == n && connector.rest.size() == n - 1 &&
                    (connector.sections.empty() || connector.sections.size() == n - 1);
  const auto is_weight = [](double value) { return std::isfinite(value) && value >= 0; };
  if (!fits || !std::ranges::all_of(connector.rest, is_weight) ||
      !std::ranges::all_of(connector.particle_mass, is_weight) || !(connector.length >= 0) ||
      !is_finite(connector.mass) || connector.model > ConnectorModel::span) {
    return false;
  }
  std::size_t least = 0;  // the first particle that the next hold may have
  for (const Hold& hold : connector.holds) {
    if (hold.particle < least || hold.particle >= n) return false;
    least = hold.particle + 1;
    using Kind = Attachment::Kind;
    if (hold.to.kind > Kind::body) return false;
    if (hold.to.kind == Kind::body && hold.to.body >= world.bodies.size()) return false;
    if (hold.to.kind == Kind::path && !hold.to.path) return false;
  }
  if (!connector.winch) return true;
  return connector.winch->before.size() == n && connector.winch->rest.size() == n - 1;
}

bool is_sound(const World& world) {
  const std::size_t connectors = world.connectors.size(), bodies = world.bodies.size();
  return is_finite(world.time) &&
         std::ranges::all_of(world.bodies,
                             [](const Body& body) { return body.mass_properties.mass > 0; }) &&
         std::ranges::all_of(world.connectors,
                             [&](const Connector& one) { return is_sound(world, one); }) &&
         std::ranges::all_of(world.joints,
                             [&](const Joint& joint) {
                               return joint.particles.size() >= 2 &&
                                      std::ranges::all_of(joint.particles, [&](const auto& at) {
                                        return at.connector < connectors &&
                                               at.particle <
                                                   world.connectors[at.connector].particles();
                                      });
                             }) &&
         std::ranges::all_of(world.bead_pairs,
                             [&](const BeadPair& pair) {
                               return pair.connector < connectors && pair.body < bodies;
                             }) &&
         std::ranges::all_of(world.connector_pairs, [&](const ConnectorPair& pair) {
           return pair.a < connectors && pair.b < connectors;
         });
}

}  // namespace

StateParts::StateParts(const World& start, const Timeline& timeline)
    : connectors_(start.connectors.size()) {
  for (const Body& body : start.bodies) paths_.add(body.path);
  Hash hash;
  hash.number(start.topology).number(state_hash(start));
  for (const double c : start.gravity) hash.number(c);
  for (const Connector& connector : start.connectors) {
    hash.text(connector.name).number(connector.breaks_at);
    for (const Hold& hold : connector.holds) {
      paths_.add(hold.to.path);
      paths_.add(hold.turn);
    }
    winches_.add(connector.winch);
    forces_.add(connector.applied_force);
  }
  for (const TimedPin& pin : timeline.pins) {
    hash.number(pin.connector).number(pin.along).number(pin.from).number(pin.until);
    hash.number(pin.over);
    if (!pin.to) continue;
    paths_.add(pin.to->path);
    hash.number(pin.to->kind).number(pin.to->body);
    for (const double c : pin.to->point) hash.number(c);
    hash.number(pin.to->path ? pin.to->path->fingerprint() : 0);
  }
  for (const TimedCut& cut : timeline.cuts) {
    hash.number(cut.connector).number(cut.along).number(cut.time);
  }
  fingerprint_ = hash.value();
}

std::string saved(const SavedState& state, const StateParts& parts) {
  std::string bytes(kMagic);
  Out out(parts, bytes);
  out(parts.fingerprint());
  SavedState all = state;
  visit(out, all);
  out(Hash().bytes(bytes.data(), bytes.size()).value());
  return bytes;
}

SavedState loaded(std::string_view bytes, const StateParts& parts, const World& like) {
  if (!bytes.starts_with(kMagic)) {
    throw BadState("it is no state of taut, expected a file that begins with \"taut state 1\"");
  }
  std::uint64_t sum = 0, fingerprint = 0;
  if (bytes.size() < kMagic.size() + 2 * sizeof sum) damaged();
  const std::string_view before = bytes.substr(0, bytes.size() - sizeof sum);
  std::memcpy(&sum, bytes.data() + before.size(), sizeof sum);
  if (Hash().bytes(before.data(), before.size()).value() != sum) damaged();
  In in(parts, before.substr(kMagic.size()));
  in(fingerprint);
  if (fingerprint != parts.fingerprint()) {
    throw BadState(
        "the state is of another scene, expected one with the same world at the start, and the "
        "same "
        "pins and cuts");
  }
  SavedState state{.world = like};
  visit(in, state);
  if (!in.done() || !is_sound(state.world)) damaged();
  // Each cut has added a connector.
  for (std::size_t i = 0; i < state.cuts.size(); ++i) {
    const SavedState::Cut& cut = state.cuts[i];
    const bool fits = cut.whole < parts.connectors() && std::isfinite(cut.along) &&
                      cut.connector == parts.connectors() + i;
    if (!fits) damaged();
  }
  if (state.world.connectors.size() != parts.connectors() + state.cuts.size()) damaged();
  if (structure(state.world) != state.world.topology) damaged();
  return state;
}

}  // namespace taut
