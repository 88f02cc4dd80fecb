#include "sim/methods/direct/net.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "sim/methods/direct/tridiagonal.h"

namespace taut::direct {
namespace {

const Hold* hold_at(const Connector& connector, std::size_t particle) {
  const auto hold = std::ranges::lower_bound(connector.holds, particle, {}, &Hold::particle);
  return hold != connector.holds.end() && hold->particle == particle ? &*hold : nullptr;
}

/// An error of velocity counts for this share of the time in which a pendulum of the net's length
/// would turn it into an error of position.
constexpr double kMemoryShare = 0.15;
constexpr double kStandardGravity = 9.80665;  // m/s^2

/// A particle without mass, which the model has no equation for, is taken to weigh this share of
/// everything that moves with it.
constexpr double kLeastMassShare = 1e-9;

}  // namespace

Net::Net(const World& world, Component component)
    : world_(&world), component_(std::move(component)) {
  for (const std::size_t body : component_.bodies) {
    const MassProperties& m = world.bodies[body].mass_properties;
    Part part;
    part.body = body;
    part.mass = m.mass;
    part.inertia = m.inertia;
    part.inverse_inertia = m.inertia.inverse();
    bodies_.push_back(part);
  }
  order_spans(world);
  measure_links(world);
  couple();
}

void Net::add_span(const World& world, const SpanRange& range, bool reversed) {
  const Connector& connector = world.connectors[range.connector];
  Span span;
  span.range = range;
  span.offset = links_;
  span.links = range.last - range.first;
  span.reversed = reversed;
  const auto end = [&](std::size_t particle, std::size_t link, double pull) {
    const Hold* hold = hold_at(connector, particle);
    if (!hold) return kNone;
    End made;
    made.link = link;
    made.pull = pull;
    made.to = hold->to;
    if (!is_prescribed(world, hold->to)) {
      made.body = static_cast<std::size_t>(std::ranges::find(component_.bodies, hold->to.body) -
                                           component_.bodies.begin());
      made.local_arm = hold->to.point - world.bodies[hold->to.body].mass_properties.centre;
      bodies_[made.body].ends.push_back(ends_.size());
    }
    ends_.push_back(made);
    return ends_.size() - 1;
  };
  span.first = end(span.particle(0), span.offset, 1);
  span.last = end(span.particle(span.links), span.offset + span.links - 1, -1);
  links_ += span.links;
  spans_.push_back(span);
}

/// Walks from the prescribed holds (or, where there are none, from a body or a free end) along the
/// spans, so that each span starts where one before it ended.
void Net::order_spans(const World& world) {
  std::vector<char> placed(bodies_.size(), 0);
  std::vector<char> done(component_.spans.size(), 0);
  const auto body_of = [&](const SpanRange& range, std::size_t particle) {
    const Hold* hold = hold_at(world.connectors[range.connector], particle);
    if (!hold || is_prescribed(world, hold->to)) return kNone;
    return static_cast<std::size_t>(std::ranges::find(component_.bodies, hold->to.body) -
                                    component_.bodies.begin());
  };
  const auto known = [&](const SpanRange& range, std::size_t particle) {
    const Hold* hold = hold_at(world.connectors[range.connector], particle);
    if (!hold) return false;
    const std::size_t body = body_of(range, particle);
    return body == kNone || placed[body];
  };
  const auto take = [&](std::size_t s, bool reversed) {
    const SpanRange& range = component_.spans[s];
    done[s] = 1;
    const std::size_t far = reversed ? range.first : range.last;
    const bool closes = known(range, far);
    add_span(world, range, reversed);
    spans_.back().closes = closes;
    if (const std::size_t body = body_of(range, far); body != kNone) placed[body] = 1;
  };
  const auto grow = [&] {
    for (bool more = true; more;) {
      more = false;
      for (std::size_t s = 0; s < component_.spans.size(); ++s) {
        const SpanRange& range = component_.spans[s];
        if (done[s]) continue;
        const bool first = known(range, range.first), last = known(range, range.last);
        if (!first && !last) continue;
        take(s, !first);
        more = true;
      }
    }
  };
  grow();
  floats_ = spans_.empty();
  if (!floats_) return;
  if (!bodies_.empty()) {
    placed[0] = 1;
    grow();
  } else {
    take(0, false);
  }
}

void Net::measure_links(const World& world) {
  for (const Part& part : bodies_) mass_ += part.mass;
  for (const Span& span : spans_) {
    const Connector& connector = world.connectors[span.range.connector];
    for (std::size_t k = 0; k <= span.links; ++k) {
      const bool held = (k == 0 && span.first != kNone) || (k == span.links && span.last != kNone);
      particle_mass_.push_back(held ? 0 : connector.particle_mass[span.particle(k)]);
      mass_ += particle_mass_.back();
    }
  }
  const double least = kLeastMassShare * (mass_ > 0 ? mass_ : 1);

  rest_.resize(links_);
  inverse_rest_.resize(links_);
  both_.resize(links_);
  shared_.assign(links_, 0.0);
  std::size_t p = 0;
  for (const Span& span : spans_) {
    const Connector& connector = world.connectors[span.range.connector];
    const auto inverse_mass = [&](std::size_t k) {
      const bool held = (k == 0 && span.first != kNone) || (k == span.links && span.last != kNone);
      return held ? 0 : 1 / std::max(particle_mass_[p + k], least);
    };
    for (std::size_t k = 0; k < span.links; ++k) {
      const std::size_t link = span.offset + k;
      const std::size_t first = std::min(span.particle(k), span.particle(k + 1));
      rest_[link] = connector.rest[first];
      inverse_rest_[link] = rest_[link] > 0 ? 1 / rest_[link] : 0;
      both_[link] = inverse_mass(k) + inverse_mass(k + 1);
      if (k + 1 < span.links) shared_[link] = inverse_mass(k + 1);
    }
    p += span.links + 1;
  }
  const double length = std::accumulate(rest_.begin(), rest_.end(), 0.0);
  memory_ = kMemoryShare * std::sqrt(length / kStandardGravity);
  points_.resize(particle_mass_.size());
  centres_.resize(bodies_.size());
  diagonal_.resize(links_);
  off_.resize(links_);
  tension_.resize(links_);
}

void Net::couple() {
  const auto row = [&](std::size_t link) {
    const auto found = std::ranges::find(coupled_, link);
    if (found == coupled_.end()) {
      coupled_.push_back(link);
      return coupled_.size() - 1;
    }
    return static_cast<std::size_t>(found - coupled_.begin());
  };
  for (const Part& part : bodies_) {
    for (const std::size_t a : part.ends) {
      for (const std::size_t b : part.ends) {
        if (a != b) couplings_.push_back({a, b, row(ends_[a].link), row(ends_[b].link)});
      }
    }
  }
  const auto n = static_cast<Eigen::Index>(coupled_.size());
  response_.resize(links_ * coupled_.size());
  dense_.resize(n, n);
  gain_.resize(n, n);
  dense_right_.resize(n);
}

void Net::read_bodies(const double* q, const double* rate) {
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    Part& part = bodies_[b];
    const double* p = q + 3 * links_ + 4 * b;
    const double* r = rate + 3 * links_ + 4 * b;
    const Quat rotation(p[0], p[1], p[2], p[3]), turning(r[0], r[1], r[2], r[3]);
    // q' = W q / 2, W the spin as a quaternion.
    part.spin = 2 / rotation.squaredNorm() * (turning * rotation.conjugate()).vec();
    part.rotation = rotation.normalized().toRotationMatrix();
    part.world_inverse_inertia = part.rotation * part.inverse_inertia * part.rotation.transpose();
    const Vec3 momentum = part.rotation * (part.inertia * (part.rotation.transpose() * part.spin));
    part.spin_rate = part.world_inverse_inertia * momentum.cross(part.spin);
    for (const std::size_t e : part.ends) {
      End& end = ends_[e];
      end.arm = part.rotation * end.local_arm;
      end.lead = part.spin.cross(part.spin.cross(end.arm)) + part.spin_rate.cross(end.arm);
    }
  }
}

void Net::read_holds(double time) {
  for (End& end : ends_) {
    if (end.body == kNone) {
      end.lead = hold_motion(*world_, end.to, time).acceleration - world_->gravity;
    }
  }
}

/// The tridiagonal system: -u_i . (a_{i+1} - a_i) as far as tensions cause it, = l |u'|^2 + the
/// rest.
void Net::assemble(const double* q, const double* rate) {
  const double *x = q, *y = q + links_, *z = q + 2 * links_;
  const double *vx = rate, *vy = rate + links_, *vz = rate + 2 * links_;
  for (std::size_t i = 0; i + 1 < links_; ++i) {
    off_[i] = -shared_[i] * (x[i] * x[i + 1] + y[i] * y[i + 1] + z[i] * z[i + 1]);
  }
  for (std::size_t i = 0; i < links_; ++i) {
    diagonal_[i] = both_[i];
    tension_[i] = rest_[i] * (vx[i] * vx[i] + vy[i] * vy[i] + vz[i] * vz[i]);
  }
  for (const End& end : ends_) {
    const Vec3 u = at(q, end.link);
    tension_[end.link] -= end.pull * u.dot(end.lead);
    if (end.body == kNone) continue;
    const Part& part = bodies_[end.body];
    const Vec3 turn = end.arm.cross(u);
    diagonal_[end.link] += 1 / part.mass + turn.dot(part.world_inverse_inertia * turn);
  }
}

/// Bodies that several links hold add B = E Q E' to the tridiagonal A, E the columns of the unit
/// matrix for those links: T = A^-1 r - A^-1 E (1 + Q G)^-1 Q E' A^-1 r, G = E' A^-1 E (Woodbury).
void Net::add_couplings(const double* q) {
  const std::size_t n = coupled_.size();
  for (std::size_t k = 0; k < n; ++k) {
    double* column = response_.data() + k * links_;
    std::fill(column, column + links_, 0.0);
    column[coupled_[k]] = 1;
    Tridiagonal::solve(links_, diagonal_.data(), off_.data(), column);
  }
  dense_.setZero();
  for (const Coupling& c : couplings_) {
    const End &a = ends_[c.a], &b = ends_[c.b];
    const Part& part = bodies_[a.body];
    const Vec3 u = at(q, a.link), v = at(q, b.link);
    dense_(static_cast<Eigen::Index>(c.row), static_cast<Eigen::Index>(c.column)) +=
        a.pull * b.pull *
        (u.dot(v) / part.mass + a.arm.cross(u).dot(part.world_inverse_inertia * b.arm.cross(v)));
  }
  for (std::size_t k = 0; k < n; ++k) {
    dense_right_[static_cast<Eigen::Index>(k)] = tension_[coupled_[k]];
    for (std::size_t j = 0; j < n; ++j) {
      gain_(static_cast<Eigen::Index>(k), static_cast<Eigen::Index>(j)) =
          response_[j * links_ + coupled_[k]];
    }
  }
  dense_right_ = (dense_ * dense_right_).eval();
  gain_ = (Eigen::MatrixXd::Identity(gain_.rows(), gain_.cols()) + dense_ * gain_).eval();
  dense_right_ = gain_.partialPivLu().solve(dense_right_).eval();
  for (std::size_t k = 0; k < n; ++k) {
    const double share = dense_right_[static_cast<Eigen::Index>(k)];
    const double* column = response_.data() + k * links_;
    for (std::size_t i = 0; i < links_; ++i) tension_[i] -= share * column[i];
  }
}

void Net::acceleration(double time, const double* q, const double* rate, double* out) {
  read_bodies(q, rate);
  read_holds(time);
  assemble(q, rate);
  Tridiagonal::factor(links_, diagonal_.data(), off_.data());
  Tridiagonal::solve(links_, diagonal_.data(), off_.data(), tension_.data());
  if (!coupled_.empty()) add_couplings(q);

  const double* T = tension_.data();
  for (std::size_t c = 0; c < 3; ++c) {
    const double* u = q + c * links_;
    double* a = out + c * links_;
    for (std::size_t i = 0; i < links_; ++i) a[i] = -both_[i] * T[i] * u[i];
    for (std::size_t i = 0; i + 1 < links_; ++i) {
      a[i] += shared_[i] * T[i + 1] * u[i + 1];
      a[i + 1] += shared_[i] * T[i] * u[i];
    }
  }
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    const Part& part = bodies_[b];
    Vec3 force = Vec3::Zero(), torque = Vec3::Zero();
    for (const std::size_t e : part.ends) {
      const Vec3 pull = ends_[e].pull * T[ends_[e].link] * at(q, ends_[e].link);
      force += pull;
      torque += ends_[e].arm.cross(pull);
    }
    const Vec3 turn = part.world_inverse_inertia * torque;
    for (const std::size_t e : part.ends) {
      ends_[e].lead += force / part.mass + turn.cross(ends_[e].arm);
    }
    const Vec3 alpha = part.spin_rate + turn;
    const double* p = q + 3 * links_ + 4 * b;
    const Quat rotation(p[0], p[1], p[2], p[3]);
    const Quat rise = Quat(0, alpha.x(), alpha.y(), alpha.z()) * rotation;
    const double inward = part.spin.squaredNorm() / 4;
    double* a = out + 3 * links_ + 4 * b;
    a[0] = rise.w() / 2 - inward * p[0];
    a[1] = rise.x() / 2 - inward * p[1];
    a[2] = rise.y() / 2 - inward * p[2];
    a[3] = rise.z() / 2 - inward * p[3];
  }
  for (const End& end : ends_) add(out, end.link, -end.pull * end.lead);
  for (std::size_t c = 0; c < 3; ++c) {
    double* a = out + c * links_;
    for (std::size_t i = 0; i < links_; ++i) a[i] *= inverse_rest_[i];
  }
}

}  // namespace taut::direct
