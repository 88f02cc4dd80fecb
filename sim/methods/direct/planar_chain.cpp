#include "sim/methods/direct/planar_chain.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "sim/links/stick.h"
#include "sim/methods/direct/scales.h"
#include "sim/methods/direct/sincos.h"
#include "sim/methods/direct/tridiagonal.h"
#include "sim/methods/direct/vector.h"

namespace taut::direct {
namespace {

constexpr std::size_t kArrays = 23;

using Out = double* __restrict;
using In = const double* __restrict;

TAUT_VECTOR_CLONES
void assemble(std::size_t n, In angle, In rate, In beside, In weight, Out cosine, Out sine, Out off,
              Out turned, Out right) {
  for (std::size_t k = 0; k < n; ++k) {
    const SinCos turn = sine_and_cosine(angle[k + 1] - angle[k]);
    cosine[k] = turn.cosine;
    sine[k] = turn.sine;
    off[k] = beside[k] * turn.cosine;
    const double across = beside[k] * turn.sine;
    turned[k] = across * across;
    right[k] = weight[k] * (rate[k] * rate[k]);
  }
}

TAUT_VECTOR_CLONES
void scale_links(std::size_t n, In inverse, In rest, Out scale, Out near, Out far, Out weight) {
  for (std::size_t k = 0; k < n; ++k) {
    const double square = 2 / (inverse[k - 1] + inverse[k]);
    scale[k] = std::sqrt(square);
    near[k] = square * inverse[k - 1];
    far[k] = square * inverse[k];
    weight[k] = rest[k] * scale[k];
  }
}

/// The scales before the first and behind the last link are zero, and so are the gains.
TAUT_VECTOR_CLONES
void weigh_gains(std::size_t n, In inverse, In rest, In scale, Out beside, Out next_gain,
                 Out last_gain, Out wave_gain) {
  for (std::size_t k = 0; k < n; ++k) {
    const double per_rest = 1 / rest[k];
    beside[k] = inverse[k] * scale[k] * scale[k + 1];
    next_gain[k] = inverse[k] * scale[k + 1] * per_rest;
    last_gain[k] = inverse[k - 1] * scale[k - 1] * per_rest;
    wave_gain[k] = 2 * (inverse[k - 1] + inverse[k]) * scale[k] * per_rest;
  }
}

/// The angles' accelerations; returns the largest of wave_gain * |x|.
TAUT_VECTOR_CLONES
double turn(std::size_t n, In sine, In next_gain, In last_gain, In wave_gain, In x, Out out) {
  for (std::size_t k = 0; k < n; ++k) {
    out[k] = next_gain[k] * x[k + 1] * sine[k] - last_gain[k] * x[k - 1] * sine[k - 1];
  }
  return largest(n, x, wave_gain);
}

/// Adds `change` to x; returns whether every |x| was below `most`.
TAUT_VECTOR_CLONES
bool add(std::size_t n, double most, In change, Out x) {
  std::size_t outside = 0;
  for (std::size_t k = 0; k < n; ++k) {
    outside |= std::abs(x[k]) < most ? 0 : 1;
    x[k] += change[k];
  }
  return outside == 0;
}

/// The rows of factor(), less what the first link hangs from; `down` begins a row before.
TAUT_VECTOR_CLONES
void factor_links(std::size_t n, double sigma_squared, In rest, In next_gain, In last_gain,
                  In cosine, In unknown, Out pivot, Out up, Out down) {
  for (std::size_t k = 0; k < n; ++k) {
    const double next = rest[k] * next_gain[k] * std::max(unknown[k + 1] * cosine[k], 0.0);
    const double last = rest[k] * last_gain[k] * std::max(unknown[k - 1] * cosine[k - 1], 0.0);
    pivot[k] = sigma_squared * rest[k] + next + last;
    up[k] = next;
    down[k] = last;
  }
}

/// From where links lead, of any length, and the velocities that their ends have against each
/// other, in q and rate, to angles and rates.
TAUT_VECTOR_CLONES
void read_links(std::size_t n, In rest, In x, In y, Out q, Out rate) {
  for (std::size_t k = 0; k < n; ++k) {
    const double per_length = 1 / std::sqrt(x[k] * x[k] + y[k] * y[k]);
    const double cosine = x[k] * per_length, sine = y[k] * per_length;
    rate[k] = (cosine * rate[k] - sine * q[k]) / rest[k];
    q[k] = angle_of(cosine, sine);
  }
}

/// Places the particles behind the one at `position`, each `step` further in memory than the last.
TAUT_VECTOR_CLONES
void lay(std::size_t n, In rest, In cosine, In sine, In rate, const Plane& plane,
         std::ptrdiff_t step, Vec3* position, Vec3* velocity) {
  const Vector x{plane.x[0], plane.x[1], plane.x[2]}, y{plane.y[0], plane.y[1], plane.y[2]};
  Vector p{(*position)[0], (*position)[1], (*position)[2]};
  Vector v{(*velocity)[0], (*velocity)[1], (*velocity)[2]};
  for (std::size_t k = 0; k < n; ++k) {
    p += rest[k] * (cosine[k] * x + sine[k] * y);
    v += rest[k] * rate[k] * (cosine[k] * y - sine[k] * x);
    position += step, velocity += step;
    *position = {p[0], p[1], p[2]};
    *velocity = {v[0], v[1], v[2]};
  }
}

TAUT_VECTOR_CLONES
void multiply(std::size_t n, In factor, Out x) {
  for (std::size_t k = 0; k < n; ++k) x[k] *= factor[k];
}

}  // namespace

TAUT_VECTOR_CLONES
void directions(std::size_t n, const double* __restrict angle, double* __restrict cosine,
                double* __restrict sine) {
  for (std::size_t k = 0; k < n; ++k) {
    const SinCos direction = sine_and_cosine(angle[k]);
    cosine[k] = direction.cosine;
    sine[k] = direction.sine;
  }
}

bool PlanarChain::fits(const World& world, const Component& component) {
  if (component.spans.size() != 1) return false;
  const SpanRange& span = component.spans[0];
  const Connector& connector = world.connectors[span.connector];
  const auto prescribed = [&](std::size_t particle) {
    const Hold* hold = find_hold(connector, particle);
    return hold && is_prescribed(world, hold->to);
  };
  for (std::size_t k = span.first; k < span.last; ++k) {
    if (!(connector.rest[k] > 0)) return false;
  }
  return prescribed(span.first) != prescribed(span.last);
}

void PlanarChain::reserve(std::size_t links) {
  arena_.reserve((kArrays + 2) * (links + 1 + 3 * kLanes));
}

void PlanarChain::rebuild(const World& world, const Component& component, const Plane& plane) {
  world_ = &world;
  plane_ = plane;
  range_ = component.spans[0];
  gravity_ = world.gravity;
  const Connector& connector = world.connectors[range_.connector];
  const Hold* first = find_hold(connector, range_.first);
  reversed_ = !first || !is_prescribed(world, first->to);
  hold_ = find_hold(connector, particle(0))->to;
  bar_.reset();
  if (!component.bodies.empty()) bar_ = component.bodies[0];
  links_ = range_.last - range_.first + (bar_ ? 1 : 0);
  loop_ = (links_ + 1 + kLanes - 1) / kLanes * kLanes;
  const std::size_t stride = loop_ + 2 * kLanes;
  arena_.assign((kArrays + 2) * stride, 0.0);
  double** const arrays[kArrays] = {
      &rest_,         &scale_,      &beside_,  &weight_,         &next_gain_,   &last_gain_,
      &wave_gain_,    &near_,       &far_,     &turned_,         &cosine_,      &sine_,
      &off_,          &right_,      &unknown_, &factored_pivot_, &factored_up_, &factored_down_,
      &place_cosine_, &place_sine_, &mass_,    &inverse_,        &work_};
  static_assert(std::size(arrays) == kArrays);
  for (std::size_t k = 0; k < kArrays && arrays[k]; ++k) {
    *arrays[k] = arena_.data() + kLanes + k * stride;
  }
  measure(world);
}

void PlanarChain::measure(const World& world) {
  const Connector& connector = world.connectors[range_.connector];
  const std::size_t particles = range_.last - range_.first + 1;
  for (std::size_t k = 1; k < particles; ++k) {
    rest_[k] = connector.rest[std::min(particle(k - 1), particle(k))];
    mass_[k] = connector.particle_mass[particle(k)];
  }
  if (bar_) {
    const Body& body = world.bodies[*bar_];
    const MassProperties& m = body.mass_properties;
    const Vec3 normal = body.rotation.conjugate() * plane_.normal;
    const Hold* hold = find_hold(connector, particle(particles - 1));
    arm_ = (hold->to.point - m.centre).norm();
    const Stick stick(m.mass, normal.dot(m.inertia * normal), arm_);
    mass_[links_ - 1] = stick.tip;
    mass_[links_] = stick.far;
    rest_[links_] = stick.reach;
  }
  double total = 0, length = 0, reach = 0, shortest = rest_[1];
  for (std::size_t k = 1; k <= links_; ++k) {
    total += mass_[k];
    length += rest_[k];
    shortest = std::min(shortest, rest_[k]);
    // Cauchy's and Schwarz's inequality for the sum in displacement().
    reach += static_cast<double>(links_ + 1 - k) * rest_[k] * rest_[k];
  }
  length_ = length, shortest_ = shortest;
  reach_ = std::sqrt(reach / static_cast<double>(links_));
  velocity_time_ = velocity_time_of(length);
  const double least = kLeastMassShare * (total > 0 ? total : 1);
  for (std::size_t k = 1; k <= links_; ++k) inverse_[k] = 1 / std::max(mass_[k], least);
  scale_links(links_, inverse_ + 1, rest_ + 1, scale_ + 1, near_ + 1, far_ + 1, weight_ + 1);
  weigh_gains(links_, inverse_ + 1, rest_ + 1, scale_ + 1, beside_ + 1, next_gain_ + 1,
              last_gain_ + 1, wave_gain_ + 1);
}

void PlanarChain::load(const World& world, double, double* q, double* rate) {
  attach(world);
  left_plane_.reset();
  gravity_ = world.gravity;
  std::fill_n(q, size(), 0.0);
  std::fill_n(rate, size(), 0.0);
  const Connector& connector = world.connectors[range_.connector];
  const Vec3 *position = connector.position.data(), *velocity = connector.velocity.data();
  double *x = place_cosine_, *y = place_sine_;  // along the links
  const Plane plane = plane_;                   // nothing else can be q or rate
  Vec3 u = world.gravity.norm() > 0 ? world.gravity : plane.x;
  const std::size_t particles = range_.last - range_.first + 1;
  for (std::size_t k = 1; k < particles; ++k) {
    const std::size_t a = particle(k - 1), b = particle(k);
    const Vec3 gap = position[b] - position[a], change = velocity[b] - velocity[a];
    const double least = 1e-9 * rest_[k];
    // Particles that coincide say nothing of the link between them: it goes on like the last.
    if (gap.squaredNorm() > least * least) u = gap;
    x[k] = u.dot(plane.x), y[k] = u.dot(plane.y);
    q[k] = change.dot(plane.x), rate[k] = change.dot(plane.y);
  }
  const Body* body = bar_ ? &world.bodies[*bar_] : nullptr;
  if (body) {
    u = body->position - position[particle(particles - 1)];
    x[links_] = u.dot(plane.x), y[links_] = u.dot(plane.y);
  }
  read_links(links_, rest_ + 1, x + 1, y + 1, q + 1, rate + 1);
  if (!body) return;
  rate[links_] = body->spin.dot(plane.normal);
  bar_angle_ = q[links_];
  rotation_ = body->rotation;
}

void PlanarChain::store(World& world, const double* q, const double* rate) {
  attach(world);
  Connector& connector = world.connectors[range_.connector];
  directions(loop_, q, place_cosine_, place_sine_);
  const std::size_t particles = range_.last - range_.first + 1;
  const std::size_t first = particle(0), last = particle(particles - 1);
  Vec3 *position = connector.position.data(), *velocity = connector.velocity.data();
  lay(particles - 1, rest_ + 1, place_cosine_ + 1, place_sine_ + 1, rate + 1, plane_,
      reversed_ ? -1 : 1, position + first, velocity + first);
  if (!bar_) return;
  const double cosine = place_cosine_[links_], sine = place_sine_[links_];
  Body& body = world.bodies[*bar_];
  body.position = position[last] + arm_ * (cosine * plane_.x + sine * plane_.y);
  body.velocity = velocity[last] + arm_ * rate[links_] * (cosine * plane_.y - sine * plane_.x);
  body.rotation = Quat(Eigen::AngleAxisd(q[links_] - bar_angle_, plane_.normal)) * rotation_;
  body.spin = rate[links_] * plane_.normal;
}

void PlanarChain::set_pull(double time) {
  pull_ = gravity_;
  if (rests(hold_, time)) return;
  pull_ -= hold_motion(*world_, hold_, time).acceleration;
  if (!plane_.holds(pull_)) left_plane_ = pull_;
}

void PlanarChain::acceleration(double time, const double* q, const double* rate, double* out) {
  set_pull(time);
  const double fx = pull_.dot(plane_.x), fy = pull_.dot(plane_.y);
  assemble(loop_, q, rate, beside_, weight_, cosine_, sine_, off_, turned_, right_);
  right_[1] += scale_[1] * (cosine_[0] * fx + sine_[0] * fy);
  solve_chain(links_, near_ + 1, far_ + 1, off_ + 1, turned_ + 1, right_ + 1, unknown_ + 1, work_);
  wave_squared_ = turn(loop_, sine_, next_gain_, last_gain_, wave_gain_, unknown_, out);
  out[1] += (cosine_[0] * fy - sine_[0] * fx) / rest_[1];
  for (std::size_t k = loop_; k < size(); ++k) out[k] = 0;
}

/// Of a link 40 operations in vectors of two numbers or more, a division, and the elimination from
/// both ends at once, three operations that wait for each other there and back.
double PlanarChain::work() const {
  return 450 + 20 * static_cast<double>(links_) + (hold_.kind == Attachment::Kind::fixed ? 0 : 100);
}

/// As if the links were parallel. Four parts of the sum go on at once.
double PlanarChain::displacement(const double* change) const {
  constexpr std::size_t kParts = 4;
  double place[kParts] = {}, sum[kParts] = {}, squares[kParts] = {};
  const std::size_t length = links_ / kParts;
  const auto add = [&](std::size_t part, std::size_t k) {
    place[part] += rest_[k] * change[k];
    sum[part] += place[part];
    squares[part] += place[part] * place[part];
  };
  for (std::size_t i = 1; i <= length; ++i) {
    for (std::size_t part = 0; part < kParts; ++part) add(part, part * length + i);
  }
  for (std::size_t k = kParts * length + 1; k <= links_; ++k) add(kParts - 1, k);
  double total = squares[0], before = place[0];
  for (std::size_t part = 1; part < kParts; ++part) {
    const std::size_t count = part + 1 < kParts ? length : links_ - part * length;
    total += before * (static_cast<double>(count) * before + 2 * sum[part]) + squares[part];
    before += place[part];
  }
  return std::sqrt(std::max(total, 0.0) / static_cast<double>(links_));
}

/// Angles know no edge of the chart, but more than half a turn is nonsense.
bool PlanarChain::retract(const double* base, double* x, double*) const {
  constexpr double kHalfTurn = 3.141592653589793;
  return add(loop_, kHalfTurn, base, x);
}

/// sigma^2 - L, rows times l: L p is what the tensions make of a change p of the angles, as far as
/// they pull and the links do not fold.
void PlanarChain::factor(double sigma_squared) {
  const double first =
      std::max(cosine_[0] * pull_.dot(plane_.x) + sine_[0] * pull_.dot(plane_.y), 0.0);
  factor_links(links_, sigma_squared, rest_ + 1, next_gain_ + 1, last_gain_ + 1, cosine_ + 1,
               unknown_ + 1, factored_pivot_ + 1, factored_up_ + 1, factored_down_);
  factored_pivot_[1] += first;
  factor_twisted(links_, factored_pivot_ + 1, factored_up_ + 1, factored_down_ + 1, work_);
}

void PlanarChain::solve_factored(double* x) const {
  multiply(links_, rest_ + 1, x + 1);
  solve_twisted(links_, factored_pivot_ + 1, factored_up_ + 1, factored_down_ + 1, 1, 0, x + 1);
}

void PlanarChain::solve_factored(double* x, double* y) const {
  for (double* right : {x, y}) multiply(links_, rest_ + 1, right + 1);
  const auto stride = static_cast<std::size_t>(y - x);
  solve_twisted(links_, factored_pivot_ + 1, factored_up_ + 1, factored_down_ + 1, 2, stride,
                x + 1);
}

}  // namespace taut::direct
