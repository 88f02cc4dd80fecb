#include "sim/run/forces.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <sstream>
#include <utility>
#include <vector>

#include "sim/measure/measure.h"
#include "sim/methods/direct/implicit.h"
#include "sim/methods/direct/spans.h"
#include "sim/run/method.h"

namespace taut::direct {
namespace {

using PartOf = Eigen::Map<const Vec3>;

constexpr double kTouching = 1e-5;       // of the longest connector
constexpr double kShortStep = 1e-4;      // of the time in which the shortest link falls its length
constexpr double kShortestStep = 1e-13;  // s
constexpr double kStays = 1e-8;          // of the largest force
constexpr int kMostRounds = 20;
constexpr double kBalanced = 1e-4;  // of the largest force or weight, and of accelerations

class Finder {
 public:
  explicit Finder(const World& world) : world_(world) { step_.rebuild(world); }

  Forces find() {
    const double length = length_scale(world_);
    step_.set_lowest_speeds(std::sqrt(2 * world_.gravity.norm() * kTouching * length),
                            kTouching * length);
    if (!step_.load(world_, from_, kTouching * length)) fail();
    // Stiff materials need a step that follows their waves.
    for (double h = kShortStep * shortest_time(); h > kShortestStep; h /= 10) {
      if (!take(h) || !refine(h)) continue;
      Forces made{.time = world_.time};
      step_.mechanism().place_and_measure(from_.time, from_.state.data());
      on_point_.assign(step_.mechanism().points(), Vec3::Zero());
      add_links(made);
      add_contacts(made);
      add_holds(made);
      if (is_in_balance(h)) return made;
    }
    fail();
  }

 private:
  [[noreturn]] void fail() const {
    std::ostringstream line;
    line << "no forces satisfy the laws of all links and contacts at " << world_.time << " s";
    throw Diverged("forces", world_.time, line.str());
  }

  double shortest_time() const {
    double shortest = length_scale(world_), fastest = 0;
    if (!(shortest > 0)) shortest = 1;
    for (const Connector& connector : world_.connectors) {
      for (const double rest : connector.rest) {
        if (rest > 0) shortest = std::min(shortest, rest);
      }
      for (const Vec3& velocity : connector.velocity) fastest = std::max(fastest, velocity.norm());
    }
    const double falls = std::sqrt(shortest / std::max(world_.gravity.norm(), 1.0));
    return fastest > 0 ? std::min(falls, shortest / fastest) : falls;
  }

  /// Takes a step of h (s) and one of h / 2. Their forces are extrapolated to a step of no length.
  bool take(double h) {
    using Result = ImplicitStep::Result;
    return step_.step(from_, h, 0, false, whole_) != Result::failed &&
           step_.step(from_, h / 2, 0, false, half_) != Result::failed;
  }

  /// Newton's method ends where velocities stay, and forces between masses of very different size
  /// may still change: it begins again from them until they stay, too. Forces that share a load in
  /// more than one way may never stay.
  bool refine(double h) {
    for (int round = 0; round < kMostRounds; ++round) {
      double change = 0, most = 0;
      for (std::size_t k = 0; k < from_.tension.size(); ++k) {
        if (step_.links()[k].soft) continue;
        change = std::max(change, std::abs(half_.tension[k] - from_.tension[k]));
        most = std::max(most, std::abs(half_.tension[k]));
        from_.tension[k] = half_.tension[k];
      }
      for (std::size_t c = 0; c < from_.contacts.size(); ++c) {
        const Vec3& force = half_.contacts[c].force;
        change = std::max(change, (force - from_.contacts[c].force).norm());
        most = std::max(most, force.norm());
        from_.contacts[c].force = force;
      }
      if (change <= kStays * most) return true;
      if (!take(h)) return false;
    }
    return true;
  }

  /// A force that is zero in one of the steps stays as it is.
  static double extrapolated(double half, double whole) {
    return half == 0 || whole == 0 ? half : 2 * half - whole;
  }

  PartOf place(std::size_t point) const {
    return PartOf(&from_.state[step_.mechanism().position(point)]);
  }
  PartOf velocity(std::size_t point) const {
    return PartOf(&from_.state[step_.mechanism().velocity(point)]);
  }

  void add_links(Forces& made) {
    const Mechanism& mechanism = step_.mechanism();
    for (std::size_t k = 0; k < step_.links().size(); ++k) {
      const ImplicitStep::Link& link = step_.links()[k];
      Vec3 along = place(link.b) - place(link.a);
      const double length = along.norm();
      if (length > 0) along /= length;
      double tension = extrapolated(half_.tension[k], whole_.tension[k]);
      std::size_t connector = 0, index = 0;
      bool joint = false;
      if (link.soft) {
        const auto& stretch = mechanism.material().stretches()[link.row];
        connector = stretch.connector;
        index = stretch.link;
        const double rate = along.dot(velocity(link.b) - velocity(link.a)) - stretch.rest_rate;
        tension = stretch.tension(length, rate);
      } else {
        const Row& row = mechanism.rows()[link.row];
        connector = row.connector;
        index = row.link;
        joint = row.axis != Row::kAlongLink;
        if (joint) along = Vec3::Unit(row.axis);
      }
      on_point_[link.a] += tension * along;
      on_point_[link.b] -= tension * along;
      const Vec3 middle = (place(link.a) + place(link.b)) / 2;
      Forces::Link* last = made.links.empty() ? nullptr : &made.links.back();
      if (joint && last && last->connector == connector && last->link == index) {
        const Vec3 pull = last->tension * last->direction + tension * along;
        last->tension = pull.norm();
        last->direction = last->tension > 0 ? Vec3(pull / last->tension) : along;
      } else {
        made.links.push_back({connector, index, tension, middle, along});
      }
    }
    std::ranges::stable_sort(made.links, {}, [](const Forces::Link& link) {
      return std::pair(link.connector, link.link);
    });
  }

  void add_contacts(Forces& made) {
    Touches& touches = step_.touches();
    touches.place(world_, from_.time);
    for (std::size_t c = 0; c < half_.contacts.size(); ++c) {
      const StepState::Contact& contact = half_.contacts[c];
      const Candidate& of = touches.candidates()[contact.candidate];
      const Meeting at = touches.meet(step_.mechanism(), contact.candidate, from_.state.data());
      const Vec3& whole = whole_.contacts[c].force;
      const Vec3 force =
          contact.force.isZero(0) || whole.isZero(0) ? contact.force : 2 * contact.force - whole;
      if (!(force.dot(at.normal) > 0)) continue;
      const auto [one, other] = touches.sides(contact.candidate);
      Forces::Contact told{.one = one, .other = other, .normal = at.normal, .force = force};
      const auto push = [&](std::uint32_t first, std::uint32_t second, double share,
                            const Vec3& by) {
        on_point_[first] += (1 - share) * by;
        on_point_[second] += share * by;
      };
      told.place = step_.place_of(contact.candidate, at, from_.state);
      if (of.body == Candidate::kNone) push(of.a, of.b, at.share, force);
      if (of.is_at_rope()) push(of.c, of.d, at.other_share, -force);
      made.contacts.push_back(told);
    }
  }

  /// The acceleration of the stage that the forces belong to, m/s^2. A path's points have none.
  std::optional<Vec3> acceleration(std::size_t point) const {
    const auto half = step_.acceleration(point, half_), whole = step_.acceleration(point, whole_);
    if (!half || !whole) return std::nullopt;
    return 2 * *half - *whole;
  }

  /// All forces on a free point accelerate it, and rods keep their lengths.
  bool is_in_balance(double h) {
    const Mechanism& mechanism = step_.mechanism();
    double most = 0, off = 0;
    for (const double tension : half_.tension) most = std::max(most, std::abs(tension));
    double fastest = length_scale(world_) / std::pow(shortest_time(), 2);  // m/s^2
    for (std::size_t p = 0; p < mechanism.points(); ++p) {
      if (!(mechanism.inverse_mass()[p] > 0)) continue;
      const double mass = 1 / mechanism.inverse_mass()[p];
      const Vec3 own = *acceleration(p) - world_.gravity;
      most = std::max({most, on_point_[p].norm(), mass * world_.gravity.norm()});
      off = std::max(off, (mass * own - on_point_[p]).norm());
      fastest = std::max(fastest, own.norm());
    }
    const auto is_number = [](const Vec3& force) { return force.allFinite(); };
    if (!std::ranges::all_of(on_point_, is_number)) return false;
    // Rope that passes a pulley has forces of its flow beside these, and other lengths.
    if (mechanism.has_winches()) return true;
    if (!(off <= kBalanced * most)) return false;
    step_.mechanism().place_and_measure(half_.time, half_.state.data());
    return std::ranges::all_of(step_.links(), [&](const ImplicitStep::Link& link) {
      return link.soft || link.pulls ||
             std::abs(mechanism.rate()[link.row]) <= kBalanced * h * fastest;
    });
  }

  /// The force of a hold accelerates its particle against all others.
  void add_holds(Forces& made) {
    const Mechanism& mechanism = step_.mechanism();
    mechanism.material().add_bends(from_.state.data(), velocity(0).data(), on_point_);
    mechanism.material().add_drag(from_.state.data(), velocity(0).data(), on_point_);
    mechanism.material().add_twists(from_.state.data(), velocity(0).data(), on_point_);
    mechanism.material().add_applied(from_.state.data(), velocity(0).data(), on_point_);
    if (mechanism.has_winches()) mechanism.add_flow(from_.state.data(), on_point_);
    std::vector<double> mass(mechanism.points());
    std::size_t point = 0;
    for (const Connector& connector : world_.connectors) {
      for (const double own : connector.particle_mass) mass[mechanism.leader(point++)] += own;
    }
    std::size_t first = 0;
    for (std::size_t c = 0; c < world_.connectors.size(); ++c) {
      for (const Hold& hold : world_.connectors[c].holds) {
        const std::size_t p = mechanism.leader(first + hold.particle);
        const Vec3 at =
            acceleration(p).value_or(hold_motion(world_, hold.to, from_.time).acceleration);
        made.holds.push_back(
            {c, hold.particle, place(p), mass[p] * (at - world_.gravity) - on_point_[p]});
      }
      first += world_.connectors[c].particles();
    }
    for (const auto& clamp :
         mechanism.material().clamp_moments(from_.state.data(), velocity(0).data())) {
      const std::size_t particle = world_.connectors[clamp.connector].holds[clamp.hold].particle;
      const auto held = std::ranges::find_if(made.holds, [&](const Forces::Hold& hold) {
        return hold.connector == clamp.connector && hold.particle == particle;
      });
      held->moment = clamp.moment;
    }
  }

  const World& world_;
  ImplicitStep step_;
  StepState from_, whole_, half_;
  std::vector<Vec3> on_point_;  // N, without the forces of holds
};

/// Rigid links get the lengths that they have, and strings at least these: methods that stretch
/// them leave them at others.
World with_lengths_as_they_are(World world) {
  for (Connector& connector : world.connectors) {
    if (connector.stretches() || connector.winch || connector.model == ConnectorModel::span)
      continue;
    for (std::size_t k = 0; k < connector.links(); ++k) {
      const double length = (connector.position[k + 1] - connector.position[k]).norm();
      double& rest = connector.rest[k];
      if (rest > 0 && length > 0) rest = connector.pulls ? std::max(rest, length) : length;
    }
  }
  return world;
}

Forces find_forces(const World& world) {
  if (!has_spans(world)) return Finder(world).find();
  SpansAsStrings spans;
  spans.rebuild(world);
  spans.read(world);
  Forces made = Finder(spans.world()).find();
  std::vector<const Span*> spans_of(spans.world().connectors.size());  // null: not a span
  for (const auto& place : spans.places()) spans_of[place.string] = &place.span;
  for (Forces::Link& link : made.links) {
    if (const Span* span = spans_of[link.connector]) {
      link.connector = span->connector;
      link.link = span->a.particle;
    }
  }
  for (Forces::Hold& hold : made.holds) {
    if (const Span* span = spans_of[hold.connector]) {
      hold.connector = span->connector;
      hold.particle = hold.particle == 0 ? span->a.particle : span->b.particle;
    }
  }
  const auto link_of = [](const Forces::Link& at) { return std::pair(at.connector, at.link); };
  const auto hold_of = [](const Forces::Hold& at) { return std::pair(at.connector, at.particle); };
  std::ranges::stable_sort(made.links, {}, link_of);
  std::ranges::stable_sort(made.holds, {}, hold_of);
  std::vector<Forces::Hold> holds;
  for (const Forces::Hold& hold : made.holds) {
    if (!holds.empty() && hold_of(holds.back()) == hold_of(hold)) {  // two spans share it
      holds.back().force += hold.force;
    } else {
      holds.push_back(hold);
    }
  }
  made.holds = std::move(holds);
  return made;
}

}  // namespace
}  // namespace taut::direct

taut::Forces taut::forces_of(const World& world) {
  return direct::find_forces(direct::with_lengths_as_they_are(world));
}
