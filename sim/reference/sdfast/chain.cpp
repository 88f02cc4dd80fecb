#include "sim/reference/sdfast/chain.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "sim/motion/rotation.h"

namespace taut::sdfast {
namespace {

void require(bool holds, const char* otherwise) {
  if (!holds) throw std::invalid_argument(otherwise);
}

}  // namespace

Chain find_chain(const World& world) {
  require(world.connectors.size() == 1, "follows one connector alone");
  const Connector& connector = world.connectors.front();
  require(connector.model == ConnectorModel::links, "follows links, not massless spans");
  require(std::ranges::min(connector.rest) > 0, "follows no links without length");
  Chain chain;
  chain.links = connector.links();
  const Hold *first = nullptr, *last = nullptr;
  for (const Hold& hold : connector.holds) {
    const bool at_end = hold.particle == 0 || hold.particle == chain.links;
    require(at_end, "follows no chain that is pinned between its ends");
    require(hold.to.approach.arrival <= world.time, "follows no end that is being drawn to a pin");
    (hold.particle == 0 ? first : last) = &hold;
  }
  const auto known = [&](const Hold* hold) { return hold && is_prescribed(world, hold->to); };
  require(!known(first) || !known(last), "follows no chain whose two ends move as they are told");
  chain.reversed = known(last);
  if (chain.reversed) std::swap(first, last);
  if (first) (known(first) ? chain.held : chain.base) = first->to;
  if (last) chain.tip = last->to;
  require(!chain.base || !chain.tip || chain.base->body != chain.tip->body,
          "follows no chain whose two ends one body holds");
  for (std::size_t b = 0; b < world.bodies.size(); ++b) {
    const bool carries =
        (chain.base && chain.base->body == b) || (chain.tip && chain.tip->body == b);
    require(world.bodies[b].driven() || carries, "follows no body beside the chain");
  }
  for (std::size_t i = 0; i <= chain.links; ++i) {
    const bool carried = i == 0 ? chain.held || chain.base : i == chain.links && chain.tip;
    require(carried || connector.particle_mass[chain.particle(i)] > 0,
            "follows no particles without mass");
  }
  return chain;
}

std::optional<Plane> plane_of(const World& world, const Chain& chain) {
  if (!chain.held || chain.held->kind != Attachment::Kind::fixed || chain.tip) return {};
  const Connector& connector = world.connectors.front();
  std::vector<Vec3> vectors{world.gravity};
  for (std::size_t k = 0; k < connector.links(); ++k) {
    vectors.push_back(connector.position[k + 1] - connector.position[k]);
    vectors.push_back(connector.velocity[k + 1] - connector.velocity[k]);
  }
  return common_plane(vectors, {});
}

void set_up_pins(const Model& model, const World& world, const Chain& chain, const Plane& plane) {
  const Connector& connector = world.connectors.front();
  double gravity[3] = {world.gravity.dot(plane.x), world.gravity.dot(plane.y), 0};
  model.gravity(gravity);
  for (std::size_t k = 0; k < chain.links; ++k) {
    double arm[3] = {0, connector.rest[chain.link(k)], 0};
    model.mass(static_cast<int>(k), connector.particle_mass[chain.particle(k + 1)]);
    model.to_joint(static_cast<int>(k), arm);
  }
}

void load_pins(const World& world, const Chain& chain, const Plane& plane,
               std::vector<double>& state) {
  const Connector& connector = world.connectors.front();
  state.assign(2 * chain.links, 0);
  double angle_before = 0, spin_before = 0;
  for (std::size_t k = 0; k < chain.links; ++k) {
    const std::size_t from = chain.particle(k), to = chain.particle(k + 1);
    const Vec3 along = connector.position[to] - connector.position[from];
    const Vec3 moves = connector.velocity[to] - connector.velocity[from];
    const double x = along.dot(plane.x), y = along.dot(plane.y);
    const double angle = std::atan2(x, -y);  // from down, towards x
    const double spin = (x * moves.dot(plane.y) - y * moves.dot(plane.x)) / (x * x + y * y);
    state[k] = angle - std::exchange(angle_before, angle);
    state[chain.links + k] = spin - std::exchange(spin_before, spin);
  }
}

void store_pins(const std::vector<double>& state, const Chain& chain, const Plane& plane,
                World& world) {
  Connector& connector = world.connectors.front();
  double angle = 0, spin = 0;
  for (std::size_t k = 0; k < chain.links; ++k) {
    angle += state[k];
    spin += state[chain.links + k];
    const std::size_t from = chain.particle(k), to = chain.particle(k + 1);
    const double rest = connector.rest[chain.link(k)], s = std::sin(angle), c = std::cos(angle);
    connector.position[to] = connector.position[from] + rest * (s * plane.x - c * plane.y);
    connector.velocity[to] = connector.velocity[from] + rest * spin * (c * plane.x + s * plane.y);
  }
}

namespace {

/// kg, at the particle `i` of the chain: its own, or of the body that carries it and others.
double mass_of(const World& world, const Chain& chain, std::size_t i) {
  const Connector& connector = world.connectors.front();
  if (i == 0 && chain.base) return world.bodies[chain.base->body].mass_properties.mass;
  if (i == chain.links && chain.tip) return world.bodies[chain.tip->body].mass_properties.mass;
  return connector.particle_mass[chain.particle(i)];
}

bool is_free(const Chain& chain) {
  return !chain.held;
}

/// Walks along the joints' coordinates; the quaternions' w stand behind all others.
class Cursor {
 public:
  Cursor(const Chain& chain, double* state) : state_(state) {
    const std::size_t balls = chain.links + (is_free(chain) ? 2 : 1);
    w_ = 3 * balls + (is_free(chain) ? 3 : 0);
    rates_ = w_ + balls;
  }
  /// The next three coordinates and their rates.
  Eigen::Map<Vec3> place() const { return Eigen::Map<Vec3>(state_ + at_); }
  Eigen::Map<Vec3> rate() const { return Eigen::Map<Vec3>(state_ + rates_ + at_); }
  double& w() const { return state_[w_]; }
  void past_translation() { at_ += 3; }
  void past_ball() {
    at_ += 3;
    ++w_;
  }

 private:
  double* state_;
  std::size_t at_ = 0, w_ = 0, rates_ = 0;
};

std::size_t state_size(const Chain& chain) {
  const std::size_t balls = chain.links + (is_free(chain) ? 2 : 1);
  return 7 * balls + (is_free(chain) ? 6 : 0);
}

/// Orientation and spin (rad/s, world axes) of the model's bodies, one after another.
struct Turning {
  Quat rotation = Quat::Identity();
  Vec3 spin = Vec3::Zero();

  /// Writes the joint that takes this to `next`, and becomes it.
  void write(const Turning& next, Cursor& cursor) {
    const Quat turn = rotation.conjugate() * next.rotation;
    cursor.place() = turn.vec();
    cursor.w() = turn.w();
    cursor.rate() = next.rotation.conjugate() * (next.spin - spin);
    cursor.past_ball();
    *this = next;
  }
  /// Goes through the next joint.
  void read(Cursor& cursor) {
    Quat turn(cursor.w(), cursor.place().x(), cursor.place().y(), cursor.place().z());
    turn.normalize();
    cursor.place() = turn.vec();
    cursor.w() = turn.w();
    rotation = (rotation * turn).normalized();
    spin += rotation * Vec3(cursor.rate());
    cursor.past_ball();
  }
};

Turning of(const World& world, const std::optional<Attachment>& body) {
  if (!body) return {};
  return {world.bodies[body->body].rotation, world.bodies[body->body].spin};
}

/// m, body axes, from the centre of mass to where the body holds the chain.
Vec3 arm_of(const World& world, const Attachment& on) {
  return on.point - world.bodies[on.body].mass_properties.centre;
}

}  // namespace

void set_up_balls(const Model& model, const World& world, const Chain& chain) {
  const Connector& connector = world.connectors.front();
  Vec3 gravity = world.gravity;
  model.gravity(gravity.data());
  double total = 0;
  for (std::size_t i = is_free(chain) ? 0 : 1; i <= chain.links; ++i) {
    total += mass_of(world, chain, i);
  }
  const double length = connector.length / static_cast<double>(chain.links);
  const double moment = total / static_cast<double>(chain.links) * length * length;
  const auto end = [&](int body, std::size_t particle, const std::optional<Attachment>& on) {
    Mat3 inertia = moment * Mat3::Identity();
    if (on) inertia = world.bodies[on->body].mass_properties.inertia;
    double rows[3][3];
    for (int r = 0; r < 3; ++r) {
      for (int c = 0; c < 3; ++c) rows[r][c] = inertia(r, c);
    }
    model.mass(body, mass_of(world, chain, particle));
    model.inertia(body, rows);
    return on ? arm_of(world, *on) : Vec3(Vec3::Zero());
  };
  int body = 0;
  if (is_free(chain)) {
    Vec3 arm = end(body++, 0, chain.base);
    model.joint_on_inboard(body, arm.data());
  }
  double about_itself[3][3] = {{0, 0, 0}, {0, moment, 0}, {0, 0, 0}};
  for (std::size_t k = 0; k < chain.links; ++k, ++body) {
    Vec3 arm(0, connector.rest[chain.link(k)], 0);
    // The tip is a body of its own, particle or not.
    model.mass(body, k + 1 < chain.links ? mass_of(world, chain, k + 1) : 0);
    model.inertia(body, about_itself);
    model.to_joint(body, arm.data());
  }
  Vec3 arm = end(body, chain.links, chain.tip);
  model.to_joint(body, arm.data());
}

void load_balls(const World& world, const Chain& chain, std::vector<double>& state) {
  const Connector& connector = world.connectors.front();
  state.assign(state_size(chain), 0);
  Cursor cursor(chain, state.data());
  Turning turning;
  if (is_free(chain)) {
    const std::size_t first = chain.particle(0);
    const Body* base = chain.base ? &world.bodies[chain.base->body] : nullptr;
    cursor.place() = base ? base->position : connector.position[first];
    cursor.rate() = base ? base->velocity : connector.velocity[first];
    cursor.past_translation();
    turning.write(of(world, chain.base), cursor);
  }
  for (std::size_t k = 0; k < chain.links; ++k) {
    const std::size_t from = chain.particle(k), to = chain.particle(k + 1);
    const Vec3 up = connector.position[from] - connector.position[to];
    const Vec3 moves = connector.velocity[from] - connector.velocity[to];
    turning.write({rotation_between(Vec3::UnitY(), up), up.cross(moves) / up.squaredNorm()},
                  cursor);
  }
  turning.write(of(world, chain.tip), cursor);
}

void store_balls(std::vector<double>& state, const Chain& chain, double time, World& world) {
  Connector& connector = world.connectors.front();
  Cursor cursor(chain, state.data());
  Turning turning;
  Vec3 position, velocity;  // of the particle reached
  if (is_free(chain)) {
    position = cursor.place();
    velocity = cursor.rate();
    cursor.past_translation();
    turning.read(cursor);
    if (chain.base) {
      Body& body = world.bodies[chain.base->body];
      body.rotation = turning.rotation;
      body.spin = turning.spin;
      body.position = position;
      body.velocity = velocity;
      position = body.point(chain.base->point);
      velocity = body.point_velocity(chain.base->point);
    }
    connector.position[chain.particle(0)] = position;
    connector.velocity[chain.particle(0)] = velocity;
  } else {
    const PointMotion motion = hold_motion(world, *chain.held, time);
    position = motion.position;
    velocity = motion.velocity;
  }
  for (std::size_t k = 0; k < chain.links; ++k) {
    turning.read(cursor);
    const Vec3 down = turning.rotation * Vec3(0, -connector.rest[chain.link(k)], 0);
    position += down;
    velocity += turning.spin.cross(down);
    connector.position[chain.particle(k + 1)] = position;
    connector.velocity[chain.particle(k + 1)] = velocity;
  }
  turning.read(cursor);
  if (!chain.tip) return;
  Body& body = world.bodies[chain.tip->body];
  body.rotation = turning.rotation;
  body.spin = turning.spin;
  const Vec3 arm = body.rotation * arm_of(world, *chain.tip);
  body.position = position - arm;
  body.velocity = velocity - body.spin.cross(arm);
}

void drag_balls(const Model& model, const World& world, const Chain& chain,
                const Vec3& acceleration) {
  double centre[3] = {0, 0, 0};
  for (std::size_t k = 0; k < chain.links; ++k) {
    // The last link weighs nothing; behind it stands the tip.
    const int body = static_cast<int>(k + 1 < chain.links ? k : chain.links);
    Vec3 force = -mass_of(world, chain, k + 1) * acceleration, turned;
    model.turn(-1, force.data(), body, turned.data());
    model.push(body, centre, turned.data());
  }
}

}  // namespace taut::sdfast
