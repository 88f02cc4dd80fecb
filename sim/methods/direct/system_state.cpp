// The state of a net: to and from the world, back to where it belongs, and its error.
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "sim/methods/direct/system.h"

namespace taut::direct {
namespace {

/// The rotation rate that gives `momentum`, least where the inertia leaves a choice (a straight
/// chain about its own line).
Vec3 spin_for(const Mat3& inertia, const Vec3& momentum) {
  const Eigen::SelfAdjointEigenSolver<Mat3> eigen(inertia);
  Vec3 spin = Vec3::Zero();
  for (int k = 0; k < 3; ++k) {
    const double moment = eigen.eigenvalues()[k];
    const Vec3 axis = eigen.eigenvectors().col(k);
    if (moment > 1e-9 * eigen.eigenvalues()[2]) spin += axis.dot(momentum) / moment * axis;
  }
  return spin;
}

Mat3 point_inertia(double mass, const Vec3& r) {
  return mass * (r.squaredNorm() * Mat3::Identity() - r * r.transpose());
}

void put(double* c, const Quat& q) {
  c[0] = q.w(), c[1] = q.x(), c[2] = q.y(), c[3] = q.z();
}

Quat half_turning(const Vec3& spin, const Quat& rotation) {
  return Quat(0, spin.x() / 2, spin.y() / 2, spin.z() / 2) * rotation;
}

}  // namespace

void System::load(const World& world, double time, double* q, double* rate) {
  attach(world);
  left_plane_.reset();
  loaded_at_ = time;
  std::fill_n(q, size(), 0.0);
  std::fill_n(rate, size(), 0.0);
  const auto set = [&](std::size_t link, const Vec3& u, const Vec3& turn) {
    add(q, link, u);
    add(rate, link, turn - u.dot(turn) * u);
  };
  for (const Span& span : spans_) {
    const Connector& connector = world.connectors[span.range.connector];
    Vec3 u = world.gravity.norm() > 0 ? world.gravity.normalized()
             : plane_                 ? plane_->x
                                      : Vec3::UnitX();
    const std::size_t offset = span.offset + (span.first_bar != kNone ? 1 : 0);
    for (std::size_t k = 0; k + 1 < span.particles(); ++k) {
      const std::size_t i = offset + k, a = span.particle(k), b = span.particle(k + 1);
      const Vec3 gap = connector.position[b] - connector.position[a];
      // Particles that coincide say nothing of the link between them: it goes on like the last.
      if (gap.norm() > 1e-9 * links_.rest(i)) u = gap.normalized();
      set(i, u, links_.inverse_rest(i) * (connector.velocity[b] - connector.velocity[a]));
    }
    for (const std::size_t b : {span.first_bar, span.last_bar}) {
      if (b == kNone) continue;
      Bar& bar = bars_[b];
      const Body& body = world.bodies[bar.body];
      const std::size_t tip = span.particle(bar.outward < 0 ? 0 : span.particles() - 1);
      bar.direction = (body.position - connector.position[tip]).normalized();
      bar.rotation = body.rotation;
      set(bar.link, bar.outward * bar.direction, bar.outward * body.spin.cross(bar.direction));
    }
  }
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    const Body& body = world.bodies[bodies_[b].body];
    put(q + quaternion(b), body.rotation);
    put(rate + quaternion(b), half_turning(body.spin, body.rotation));
  }
  if (!floats_) return;

  centre_ = {};
  for (const auto* list : {&part_of_, &bar_of_}) {
    for (std::size_t b = 0; b < list->size(); ++b) {
      if ((*list)[b] == kNone) continue;
      const Body& body = world.bodies[b];
      centre_.position += body.mass_properties.mass / mass_ * body.position;
      centre_.velocity += body.mass_properties.mass / mass_ * body.velocity;
    }
  }
  for (const Span& span : spans_) {
    const Connector& connector = world.connectors[span.range.connector];
    for (std::size_t k = 0; k < span.particles(); ++k) {
      const std::size_t particle = span.particle(k);
      if (find_hold(connector, particle)) continue;
      centre_.position += connector.particle_mass[particle] / mass_ * connector.position[particle];
      centre_.velocity += connector.particle_mass[particle] / mass_ * connector.velocity[particle];
    }
  }
  place(time, q, rate);
  spin_momentum_ = rotary(time).momentum;
}

std::size_t System::first_link(std::size_t connector) const {
  const auto found = std::ranges::find_if(
      spans_, [&](const Span& span) { return span.range.connector == connector; });
  return found->offset;
}

System::Point System::start_of(const Span& span, double time) const {
  if (span.first == kNone) return {};
  const End& end = ends_[span.first];
  if (end.body == kNone) {
    const PointMotion motion = hold_motion(*world_, end.to, time);
    return {motion.position, motion.velocity};
  }
  return {centres_[end.body].position + end.arm,
          centres_[end.body].velocity + bodies_[end.body].spin.cross(end.arm)};
}

/// Fills points_, centres_ and bar_centres_: everything's place and velocity at `time`.
void System::place(double time, const double* q, const double* rate) {
  turn_bodies(q, rate);
  if (floats_ && !bodies_.empty()) centres_[0] = {};
  std::size_t p = 0;
  for (const Span& span : spans_) {
    Point point = start_of(span, time);
    points_[p++] = point;
    for (std::size_t i = span.offset; i < span.offset + span.links; ++i) {
      point.position += links_.rest(i) * at(q, i);
      point.velocity += links_.rest(i) * at(rate, i);
      points_[p++] = point;
    }
    if (!span.closes && span.last != kNone) {  // the body hangs from here
      const End& end = ends_[span.last];
      centres_[end.body] = {point.position - end.arm,
                            point.velocity - bodies_[end.body].spin.cross(end.arm)};
    }
  }
  if (floats_) float_to(time);
  place_bars(q, rate);
}

void System::place_bars(const double* q, const double* rate) {
  std::size_t p = 0;
  for (const Span& span : spans_) {
    for (const std::size_t b : {span.first_bar, span.last_bar}) {
      if (b == kNone) continue;
      const Bar& bar = bars_[b];
      const Point& tip = points_[p + (bar.outward < 0 ? 1 : span.links - 1)];
      const double reach = bar.outward * bar.arm;
      bar_centres_[b] = {tip.position + reach * at(q, bar.link),
                         tip.velocity + reach * at(rate, bar.link)};
    }
    p += span.links + 1;
  }
}

System::Point System::centre(double time) const {
  const double t = time - loaded_at_;
  return {centre_.position + t * centre_.velocity + t * t / 2 * world_->gravity,
          centre_.velocity + t * world_->gravity};
}

/// Shifts everything so that the centre of mass is on its parabola.
void System::float_to(double time) {
  Point sum;
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    sum.position += bodies_[b].mass * centres_[b].position;
    sum.velocity += bodies_[b].mass * centres_[b].velocity;
  }
  for (std::size_t k = 0; k < points_.size(); ++k) {
    sum.position += point_mass_[k] * points_[k].position;
    sum.velocity += point_mass_[k] * points_[k].velocity;
  }
  const Point goal = centre(time);
  const Vec3 shift = goal.position - sum.position / mass_;
  const Vec3 push = goal.velocity - sum.velocity / mass_;
  for (Point& point : points_) point = {point.position + shift, point.velocity + push};
  for (Point& point : centres_) point = {point.position + shift, point.velocity + push};
}

void System::store(World& world, const double* q, const double* rate) {
  attach(world);
  place(world.time, q, rate);
  std::size_t p = 0;
  for (const Span& span : spans_) {
    Connector& connector = world.connectors[span.range.connector];
    const std::size_t first = p + (span.first_bar != kNone ? 1 : 0);
    for (std::size_t k = 0; k < span.particles(); ++k) {
      connector.position[span.particle(k)] = points_[first + k].position;
      connector.velocity[span.particle(k)] = points_[first + k].velocity;
    }
    p += span.links + 1;
  }
  place_prescribed(world, world.time);  // where links lead there, but for rounding
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    Body& body = world.bodies[bodies_[b].body];
    const double* r = q + quaternion(b);
    body.position = centres_[b].position;
    body.velocity = centres_[b].velocity;
    body.rotation = Quat(r[0], r[1], r[2], r[3]);
    body.spin = bodies_[b].spin;
  }
  for (std::size_t b = 0; b < bars_.size(); ++b) {
    const Bar& bar = bars_[b];
    Body& body = world.bodies[bar.body];
    const Vec3 now = bar.outward * at(q, bar.link);
    const double angle =
        std::atan2(bar.direction.cross(now).dot(plane_->normal), bar.direction.dot(now));
    body.position = bar_centres_[b].position;
    body.velocity = bar_centres_[b].velocity;
    body.rotation = Quat(Eigen::AngleAxisd(angle, plane_->normal)) * bar.rotation;
    body.spin = now.cross(bar.outward * at(rate, bar.link));
  }
}

void System::project(double time, double* q, double* rate) {
  unit(q, rate);
  if (loops_) close(time, q, rate);
  if (floats_) restore_momentum(time, q, rate);
}

void System::unit(double* q, double* rate) const {
  links_.normalise(q, rate);
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    Eigen::Map<Eigen::Vector4d> p(q + quaternion(b)), r(rate + quaternion(b));
    p.normalize();
    r -= p.dot(r) * p;
  }
}

/// How far the last points of the spans that close loops are from their places, in gaps_; returns
/// the largest gap of place (m).
double System::measure_gaps(double time, const double* q, const double* rate) {
  place(time, q, rate);
  double largest = 0;
  std::size_t p = 0;
  for (std::size_t s = 0; s < spans_.size(); ++s) {
    const Span& span = spans_[s];
    p += span.links + 1;
    if (!span.closes) continue;
    const End& end = ends_[span.last];
    Point goal;
    if (end.body == kNone) {
      const PointMotion motion = hold_motion(*world_, end.to, time);
      goal = {motion.position, motion.velocity};
    } else {
      goal = {centres_[end.body].position + end.arm,
              centres_[end.body].velocity + bodies_[end.body].spin.cross(end.arm)};
    }
    gaps_[s] = {goal.position - points_[p - 1].position, goal.velocity - points_[p - 1].velocity};
    largest = std::max(largest, gaps_[s].position.norm());
  }
  return largest;
}

/// Shares a gap among the links of its span, and finds what the masses do to restore the lengths:
/// impulses along the links, by the system of the tensions. Adds both to `array` (q or its rate).
void System::spread(const double* q, Vec3 Point::*gap, double* array) {
  std::fill(still_.begin(), still_.end(), 0.0);
  turn_bodies(q, still_.data());
  lead_bodies();
  for (End& end : ends_) end.lead = Vec3::Zero();
  links_.assemble(q, still_.data());
  add_ends(q);
  for (std::size_t s = 0; s < spans_.size(); ++s) {
    if (!spans_[s].closes) continue;
    const Vec3 share = gaps_[s].*gap / static_cast<double>(spans_[s].links);
    for (std::size_t i = spans_[s].offset; i < spans_[s].offset + spans_[s].links; ++i) {
      links_.add_right(i, at(q, i).dot(share));
    }
  }
  respond(q, still_.data());
  for (std::size_t s = 0; s < spans_.size(); ++s) {
    if (!spans_[s].closes) continue;
    const Vec3 share = gaps_[s].*gap / static_cast<double>(spans_[s].links);
    for (std::size_t i = spans_[s].offset; i < spans_[s].offset + spans_[s].links; ++i) {
      add(still_.data(), i, links_.inverse_rest(i) * share);
    }
  }
  for (std::size_t k = 0; k < size(); ++k) array[k] += still_[k];
}

/// Closes the loops that an integrator's error has opened. Each round leaves the square of the gap.
void System::close(double time, double* q, double* rate) {
  constexpr int kRounds = 4;
  constexpr double kClosed = 1e-14;  // of the net's length
  for (int round = 0; round < kRounds; ++round) {
    if (measure_gaps(time, q, rate) <= kClosed * length_) break;
    spread(q, &Point::position, q);
    unit(q, rate);
  }
  measure_gaps(time, q, rate);
  spread(q, &Point::velocity, rate);
  unit(q, rate);
}

/// Angular momentum and inertia about the centre of mass; points_ and centres_ are up to date.
System::Rotary System::rotary(double time) const {
  const Point mean = centre(time);
  Rotary sum;
  const auto count = [&](double mass, const Point& point) {
    const Vec3 r = point.position - mean.position;
    sum.momentum += mass * r.cross(point.velocity - mean.velocity);
    sum.inertia += point_inertia(mass, r);
  };
  for (std::size_t k = 0; k < points_.size(); ++k) count(point_mass_[k], points_[k]);
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    const Part& part = bodies_[b];
    count(part.mass, centres_[b]);
    const Mat3 own = part.rotation * part.inertia * part.rotation.transpose();
    sum.momentum += own * part.spin;
    sum.inertia += own;
  }
  return sum;
}

/// Gives a floating net its angular momentum back by one rigid rotation.
void System::restore_momentum(double time, double* q, double* rate) {
  place(time, q, rate);
  const Rotary now = rotary(time);
  const Vec3 spin = spin_for(now.inertia, spin_momentum_ - now.momentum);
  for (std::size_t i = 0; i < links_.count(); ++i) add(rate, i, spin.cross(at(q, i)));
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    const double* p = q + quaternion(b);
    const Quat turn = half_turning(spin, Quat(p[0], p[1], p[2], p[3]));
    double* r = rate + quaternion(b);
    r[0] += turn.w(), r[1] += turn.x(), r[2] += turn.y(), r[3] += turn.z();
  }
}

double System::projection_cost() const {
  return loops_ ? 6 : floats_ ? 1.5 : 0.2;  // measured
}

double System::displacement(const double* change) const {
  double sum = 0;
  std::size_t count = 0;
  const double *x = change + links_.begin(0), *y = change + links_.begin(1);
  const double* z = plane_ ? y : change + links_.begin(2);
  const double in_space = plane_ ? 0 : 1;
  for (const Span& span : spans_) {
    double place[3] = {0, 0, 0}, squares[3] = {0, 0, 0};
    for (std::size_t i = span.offset; i < span.offset + span.links; ++i) {
      const double rest = links_.rest(i);
      place[0] += rest * x[i], squares[0] += place[0] * place[0];
      place[1] += rest * y[i], squares[1] += place[1] * place[1];
      place[2] += rest * z[i], squares[2] += place[2] * place[2];
    }
    sum += squares[0] + squares[1] + in_space * squares[2];
    count += span.links;
  }
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    const Part& part = bodies_[b];
    double turn = 0;
    for (std::size_t c = quaternion(b); c < quaternion(b) + 4; ++c) turn += change[c] * change[c];
    sum += 4 * turn * part.inertia.trace() / (2 * part.mass);
    ++count;
  }
  return std::sqrt(sum / static_cast<double>(count));
}

}  // namespace taut::direct
