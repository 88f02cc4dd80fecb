#include "sim/reference/simbody_model.h"

#include <Simbody.h>

#include <algorithm>
#include <deque>
#include <memory>
#include <optional>
#include <stdexcept>
#include <utility>

#include "sim/motion/rotation.h"
#include "sim/motion/stop.h"
#include "sim/world/world.h"

namespace taut::reference {
namespace {

// A world's counterparts in Simbody: vectors, rotations, masses, held points.

inline SimTK::Vec3 to_simbody(const Vec3& v) {
  return {v.x(), v.y(), v.z()};
}
inline Vec3 from_simbody(const SimTK::Vec3& v) {
  return {v[0], v[1], v[2]};
}

inline SimTK::Rotation to_simbody(const Quat& q) {
  return SimTK::Rotation(SimTK::Quaternion(q.w(), q.x(), q.y(), q.z()));
}

/// A rotation that takes z to `direction` (a unit vector, or zero for none).
inline Quat turn_z_to(const Vec3& direction) {
  return direction.isZero() ? Quat::Identity() : rotation_between(Vec3::UnitZ(), direction);
}

/// A rigid body about its centre of mass.
inline SimTK::Body::Rigid rigid(const MassProperties& mass) {
  const Mat3& i = mass.inertia;
  return SimTK::Body::Rigid(
      SimTK::MassProperties(mass.mass, SimTK::Vec3(0),
                            SimTK::Inertia(i(0, 0), i(1, 1), i(2, 2), i(0, 1), i(0, 2), i(1, 2))));
}

inline SimTK::Body::Rigid point_mass(double mass) {
  return SimTK::Body::Rigid(SimTK::MassProperties(mass, SimTK::Vec3(0), SimTK::Inertia(0)));
}

/// The motion of a point that is held where it is known beforehand.
class HeldMotion final : public SimTK::Motion::Custom::Implementation {
 public:
  HeldMotion(const World* const* world, Attachment to) : world_(world), to_(std::move(to)) {}

  SimTK::Motion::Level getLevel(const SimTK::State&) const override {
    return SimTK::Motion::Position;
  }
  void calcPrescribedPosition(const SimTK::State& state, int, SimTK::Real* q) const override {
    copy(at(state).position, q);
  }
  void calcPrescribedPositionDot(const SimTK::State& state, int, SimTK::Real* q) const override {
    copy(at(state).velocity, q);
  }
  void calcPrescribedPositionDotDot(const SimTK::State& state, int, SimTK::Real* q) const override {
    copy(at(state).acceleration, q);
  }

 private:
  PointMotion at(const SimTK::State& state) const {
    return hold_motion(**world_, to_, state.getTime());
  }
  static void copy(const Vec3& from, SimTK::Real* to) { std::copy_n(from.data(), 3, to); }

  const World* const* world_;
  Attachment to_;
};

constexpr int kAttempts = 200000;  // steps tried in one advance; more: the motion is not smooth

/// A particle, and where in the tree it is.
struct Node {
  std::size_t connector = 0, particle = 0;
  std::optional<Attachment> hold;
  std::optional<std::size_t> body;  // index into World::bodies, where a free one carries it
  std::vector<std::size_t> links;
  SimTK::MobilizedBodyIndex mounted;     // invalid until it is in the tree
  SimTK::Vec3 station = SimTK::Vec3(0);  // m, in that body's frame
};

struct Link {
  std::size_t a = 0, b = 0;  // nodes
  double rest = 0;           // m
  bool in_tree = false;
};

/// A body of the tree, in the order in which it grew.
struct Part {
  enum class Kind { held, particle, line, rigid, welded };
  Kind kind = Kind::held;
  SimTK::MobilizedBodyIndex index;
  std::size_t node = 0, from = 0;  // where it ends and, for a line, begins
  std::size_t body = 0;            // of a rigid one
};

/// The Simbody system of a world.
class Model {
 public:
  /// `*live` is the world that moves held points, at any time.
  Model(const World& world, const World* const* live);

  SimTK::State load(const World& world) const;
  void store(const SimTK::State& state, World& world) const;
  const SimTK::MultibodySystem& system() const { return system_; }

 private:
  void collect(const World& world);
  void root(std::size_t node);
  void grow();
  void mount(std::size_t from, std::size_t node, double rest);
  void mount_body(std::size_t body, SimTK::MobilizedBodyIndex index);
  void close_loops();
  Part& add(Part::Kind kind, const SimTK::MobilizedBody& mobilized, std::size_t node);
  SimTK::MobilizedBody& at(const Node& node) { return matter_.updMobilizedBody(node.mounted); }

  SimTK::MultibodySystem system_;
  SimTK::SimbodyMatterSubsystem matter_{system_};
  SimTK::GeneralForceSubsystem forces_{system_};
  const World* const* live_;
  const World& world_;  // while building
  std::vector<Node> nodes_;
  std::vector<Link> links_;
  std::vector<Part> parts_;
  std::deque<std::size_t> frontier_;  // nodes whose links are still to be followed
};

Model::Model(const World& world, const World* const* live) : live_(live), world_(world) {
  SimTK::Force::UniformGravity(forces_, matter_, to_simbody(world.gravity));
  collect(world);
  for (std::size_t n = 0; n < nodes_.size(); ++n) {
    if (nodes_[n].hold && !nodes_[n].body) root(n);
  }
  grow();
  // Parts that nothing holds float from their first body or, without one, their first particle.
  for (std::size_t b = 0; b < world.bodies.size(); ++b) {
    const auto mounted = [&](const Part& p) { return p.kind == Part::Kind::rigid && p.body == b; };
    if (world.bodies[b].driven() || std::any_of(parts_.begin(), parts_.end(), mounted)) continue;
    const SimTK::MobilizedBody::Free body(matter_.updGround(),
                                          rigid(world.bodies[b].mass_properties));
    mount_body(b, body.getMobilizedBodyIndex());
    grow();
  }
  for (std::size_t n = 0; n < nodes_.size(); ++n) {
    if (nodes_[n].mounted.isValid()) continue;
    root(n);
    grow();
  }
  close_loops();
  system_.realizeTopology();
}

void Model::collect(const World& world) {
  for (std::size_t c = 0; c < world.connectors.size(); ++c) {
    const Connector& connector = world.connectors[c];
    const std::size_t first = nodes_.size();
    for (std::size_t i = 0; i < connector.particles(); ++i) {
      nodes_.push_back(Node{});
      nodes_.back().connector = c;
      nodes_.back().particle = i;
    }
    for (const Hold& hold : connector.holds) {
      Node& node = nodes_[first + hold.particle];
      node.hold = hold.to;
      if (!is_prescribed(world, hold.to)) node.body = hold.to.body;
    }
    for (std::size_t k = 0; k < connector.links(); ++k) {
      nodes_[first + k].links.push_back(links_.size());
      nodes_[first + k + 1].links.push_back(links_.size());
      links_.push_back({first + k, first + k + 1, connector.rest[k]});
    }
  }
}

Part& Model::add(Part::Kind kind, const SimTK::MobilizedBody& mobilized, std::size_t node) {
  parts_.push_back({kind, mobilized.getMobilizedBodyIndex(), node, 0, 0});
  if (!nodes_[node].body) {
    nodes_[node].mounted = parts_.back().index;
    frontier_.push_back(node);
  }
  return parts_.back();
}

/// A held point moves as it is told; a free particle floats.
void Model::root(std::size_t node) {
  const Connector& connector = world_.connectors[nodes_[node].connector];
  if (nodes_[node].hold) {
    SimTK::MobilizedBody::Translation body(matter_.updGround(), point_mass(1));  // of no effect
    SimTK::Motion::Custom(body, new HeldMotion(live_, *nodes_[node].hold));
    add(Part::Kind::held, body, node);
  } else {
    const SimTK::MobilizedBody::Translation body(
        matter_.updGround(), point_mass(connector.particle_mass[nodes_[node].particle]));
    add(Part::Kind::particle, body, node);
  }
}

void Model::grow() {
  while (!frontier_.empty()) {
    const std::size_t node = frontier_.front();
    frontier_.pop_front();
    for (const std::size_t l : nodes_[node].links) {
      Link& link = links_[l];
      const std::size_t other = link.a == node ? link.b : link.a;
      if (nodes_[other].mounted.isValid()) continue;
      link.in_tree = true;
      mount(node, other, link.rest);
    }
  }
}

/// Hangs `node` on `from`: by a massless line along z with the particle at its far end, or, at no
/// distance, directly.
void Model::mount(std::size_t from, std::size_t node, double rest) {
  const Node& to = nodes_[node];
  SimTK::MobilizedBody* parent = &at(nodes_[from]);
  SimTK::Vec3 station = nodes_[from].station;
  const double mass = to.body ? 0 : world_.connectors[to.connector].particle_mass[to.particle];
  if (rest > 0) {
    const SimTK::MobilizedBody::LineOrientation line(*parent, station, point_mass(mass),
                                                     SimTK::Vec3(0, 0, -rest));
    add(Part::Kind::line, line, node).from = from;
    parent = &matter_.updMobilizedBody(parts_.back().index);
    station = SimTK::Vec3(0);
  } else if (!to.body) {
    const SimTK::MobilizedBody::Weld weld(*parent, station, point_mass(mass), SimTK::Vec3(0));
    add(Part::Kind::welded, weld, node);
  }
  if (!to.body) return;
  const Body& body = world_.bodies[*to.body];
  const Vec3 local = to.hold->point - body.mass_properties.centre;
  const SimTK::MobilizedBody::Ball ball(*parent, station, rigid(body.mass_properties),
                                        to_simbody(local));
  mount_body(*to.body, ball.getMobilizedBodyIndex());
}

/// Puts all particles that the body carries into the tree.
void Model::mount_body(std::size_t body, SimTK::MobilizedBodyIndex index) {
  parts_.push_back({Part::Kind::rigid, index, 0, 0, body});
  const Vec3 centre = world_.bodies[body].mass_properties.centre;
  for (std::size_t n = 0; n < nodes_.size(); ++n) {
    if (nodes_[n].body != body) continue;
    nodes_[n].mounted = index;
    nodes_[n].station = to_simbody(nodes_[n].hold->point - centre);
    frontier_.push_back(n);
  }
}

/// Links outside the tree are rods, but for those that nothing can move.
void Model::close_loops() {
  for (const Link& link : links_) {
    const Node &a = nodes_[link.a], &b = nodes_[link.b];
    const bool both_held = a.hold && b.hold && !a.body && !b.body;
    if (link.in_tree || both_held || a.mounted == b.mounted) continue;
    if (link.rest > 0) {
      SimTK::Constraint::Rod(at(a), a.station, at(b), b.station, link.rest);
    } else {
      SimTK::Constraint::Ball(at(a), a.station, at(b), b.station);
    }
  }
}

SimTK::State Model::load(const World& world) const {
  SimTK::State state = system_.getDefaultState();
  system_.realizeModel(state);
  state.setTime(world.time);
  // Orientation and spin (world axes) of each mobilized body; ground's are none.
  const auto count = static_cast<std::size_t>(matter_.getNumBodies());
  std::vector<Quat> rotation(count, Quat::Identity());
  std::vector<Vec3> spin(count, Vec3::Zero());
  for (const Part& part : parts_) {
    const SimTK::MobilizedBody& mobilized = matter_.getMobilizedBody(part.index);
    const auto parent =
        static_cast<std::size_t>(mobilized.getParentMobilizedBody().getMobilizedBodyIndex());
    const auto own = static_cast<std::size_t>(part.index);
    const Node& node = nodes_.empty() ? Node() : nodes_[part.node];
    const Connector* connector =
        part.kind == Part::Kind::rigid ? nullptr : &world.connectors[node.connector];
    rotation[own] = rotation[parent];
    spin[own] = spin[parent];
    switch (part.kind) {
      case Part::Kind::held:
      case Part::Kind::welded:
        continue;
      case Part::Kind::particle:
        mobilized.setQToFitTranslation(state, to_simbody(connector->position[node.particle]));
        mobilized.setUToFitLinearVelocity(state, to_simbody(connector->velocity[node.particle]));
        continue;
      case Part::Kind::line: {
        const Node& from = nodes_[part.from];
        const Connector& begins = world.connectors[from.connector];
        const Vec3 along = connector->position[node.particle] - begins.position[from.particle];
        const Vec3 moves = connector->velocity[node.particle] - begins.velocity[from.particle];
        const double length = along.norm();
        const Vec3 direction = length > 0 ? Vec3(along / length) : Vec3::Zero();
        rotation[own] = turn_z_to(direction);
        // The line does not turn about itself more or less than what it hangs on.
        const Vec3 turning = length > 0 ? Vec3(direction.cross(moves) / length) : Vec3::Zero();
        spin[own] = turning + spin[parent].dot(direction) * direction;
        break;
      }
      case Part::Kind::rigid: {
        const Body& body = world.bodies[part.body];
        rotation[own] = body.rotation;
        spin[own] = body.spin;
        if (parent == 0) {
          mobilized.setQToFitTranslation(state, to_simbody(body.position));
          mobilized.setUToFitLinearVelocity(state, to_simbody(body.velocity));
        }
        break;
      }
    }
    const Quat inverse = rotation[parent].conjugate();
    mobilized.setQToFitRotation(state, to_simbody(inverse * rotation[own]));
    mobilized.setUToFitAngularVelocity(state, to_simbody(inverse * (spin[own] - spin[parent])));
  }
  return state;
}

void Model::store(const SimTK::State& state, World& world) const {
  system_.realize(state, SimTK::Stage::Velocity);
  for (const Node& node : nodes_) {
    if (node.hold) continue;  // placed with what holds it
    const SimTK::MobilizedBody& mobilized = matter_.getMobilizedBody(node.mounted);
    Connector& connector = world.connectors[node.connector];
    connector.position[node.particle] =
        from_simbody(mobilized.findStationLocationInGround(state, node.station));
    connector.velocity[node.particle] =
        from_simbody(mobilized.findStationVelocityInGround(state, node.station));
  }
  for (const Part& part : parts_) {
    if (part.kind != Part::Kind::rigid) continue;
    const SimTK::MobilizedBody& mobilized = matter_.getMobilizedBody(part.index);
    Body& body = world.bodies[part.body];
    const SimTK::Quaternion q = mobilized.getBodyRotation(state).convertRotationToQuaternion();
    body.rotation = Quat(q[0], q[1], q[2], q[3]).normalized();
    body.position = from_simbody(mobilized.getBodyOriginLocation(state));
    body.velocity = from_simbody(mobilized.getBodyOriginVelocity(state));
    body.spin = from_simbody(mobilized.getBodyAngularVelocity(state));
  }
  place_held(world, state.getTime());
}

std::unique_ptr<SimTK::Integrator> make_integrator(const std::string& name,
                                                   const SimTK::System& system) {
  if (name == "verlet") return std::make_unique<SimTK::VerletIntegrator>(system);
  if (name == "runge-kutta-3") return std::make_unique<SimTK::RungeKutta3Integrator>(system);
  return std::make_unique<SimTK::RungeKuttaMersonIntegrator>(system);
}

/// Simbody's message on one line.
std::runtime_error failure(const SimTK::Exception::Base& error) {
  std::string message = error.getMessageText();
  while (!message.empty() && message.back() == '\n') message.pop_back();
  std::replace(message.begin(), message.end(), '\n', ' ');
  return std::runtime_error(message);
}

}  // namespace

struct SimbodyModel::Impl {
  Impl(const World& world, const std::string& integrator, double accuracy)
      : live(&world), model(world, &live), run(make_integrator(integrator, model.system())) {
    run->setAccuracy(accuracy);
    run->setAllowInterpolation(false);
    run->setInternalStepLimit(kAttempts);
    run->setReturnEveryInternalStep(true);
    run->initialize(model.load(world));
  }

  const World* live;
  Model model;
  std::unique_ptr<SimTK::Integrator> run;
};

SimbodyModel::SimbodyModel(const World& world, const std::string& integrator, double accuracy) {
  try {
    impl_ = std::make_unique<Impl>(world, integrator, accuracy);
  } catch (const SimTK::Exception::Base& error) {
    throw failure(error);
  }
}

SimbodyModel::~SimbodyModel() = default;

void SimbodyModel::advance(World& world, double until) {
  impl_->live = &world;
  try {
    const int before = impl_->run->getNumStepsAttempted();
    while (impl_->run->getTime() < until) {
      check_stop();
      if (impl_->run->stepTo(until) == SimTK::Integrator::ReachedStepLimit ||
          impl_->run->getNumStepsAttempted() - before > kAttempts) {
        throw std::runtime_error("its steps became too short");
      }
    }
    impl_->model.store(impl_->run->getState(), world);
  } catch (const SimTK::Exception::Base& error) {
    throw failure(error);
  }
  world.time = until;
}

double SimbodyModel::time() const {
  return impl_->run->getTime();
}
int SimbodyModel::steps() const {
  return impl_->run->getNumStepsTaken();
}
int SimbodyModel::attempts() const {
  return impl_->run->getNumStepsAttempted();
}
int SimbodyModel::realizations() const {
  return impl_->run->getNumRealizations();
}

}  // namespace taut::reference
