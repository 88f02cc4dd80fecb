// One run of a drawn scene, frame by frame, and the promises that it breaks.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "scenes/scene/scene.h"
#include "sim/evaluation/accuracy.h"
#include "sim/evaluation/run.h"
#include "sim/measure/measure.h"

namespace taut::drawn {

#ifdef TAUT_SANITIZED
inline constexpr double kSlower = 10;
#else
inline constexpr double kSlower = 1;
#endif
inline constexpr double kShare = 0.01 * kSlower;  // s of CPU time of a run: it goes no farther
inline constexpr double kSlice = 1e-3;            // s of the scene
inline constexpr double kTolerances = 3;     // that an error may have, but for one in a thousand
inline constexpr double kTruthError = 1e-6;  // of the length: what the truth is taken to claim
inline constexpr double kStretch = 1e-6;     // of a link's length

/// One run, frame by frame.
class Watch {
 public:
  Watch(const scenes::Scene& scene, const MethodChoice& method)
      : scene_(scene),
        method_(method),
        simulation_(start(scene, method)),
        closed_(is_closed(scene.world) && scene.timeline.empty()),
        claims_(method.name == "direct" || method.name == "truth"),
        error_(kTolerances * (method.name == "direct" ? number(method.settings, "tolerance")
                                                      : kTruthError * length_scale(scene.world))),
        mass_(moving_mass(scene.world)),
        at_start_(energy()) {}

  /// The promises that it breaks, a line each, until its share of CPU time or `most` frames are
  /// done.
  std::string look(int most) {
    Snapshot before = simulation_.state();
    double speed = fastest();
    const double start = thread_seconds();
    for (int frame = 1; frame <= most && thread_seconds() - start < kShare; ++frame) {
      simulation_.advance_to(frame / static_cast<double>(scene_.fps));
      const Snapshot now = simulation_.state();
      if (!is_finite(now)) return fmt::format("finite\tframe {}\n", frame);
      const double next = fastest();
      look_at_jump(before, now, std::max(speed, next), frame);
      look_at_claims(frame);
      before = now;
      speed = next;
      hashes_.push_back(state_hash(simulation_.world()));
    }
    return broken_;
  }

  const std::vector<std::uint64_t>& hashes() const { return hashes_; }  // of the frames

  /// Goes in slices instead; whether to the end.
  bool slice() {
    const double start = thread_seconds();
    for (double time = kSlice; time < scene_.duration; time += kSlice) {
      if (thread_seconds() - start > kShare) return false;
      simulation_.advance_to(time);
    }
    return true;
  }

  /// Whether two places that are held are as far apart at that time as the links between them
  /// reach, as near as they fold, or a single link does not fit: then no motion may exist.
  bool is_at_full_length(double time) const {
    constexpr double kNear = 1e-3;  // of the length
    const World& world = simulation_.world();
    if (!world.joints.empty() && is_drawn_apart(time)) return true;
    for (const Connector& c : world.connectors) {
      if (c.stretches()) continue;
      std::optional<Vec3> before;  // where the last place that is held was
      double length = 0, longest = 0;
      for (std::size_t i = 0; i < c.particles(); ++i) {
        if (const auto place = held_place({index(c), i}, time)) {
          const double apart = before ? (*place - *before).norm() : length / 2;
          const bool folded = !c.pulls && apart < 2 * longest - length + kNear * length;
          if (before && (apart > (1 - kNear) * length || folded)) return true;
          before = place;
          length = longest = 0;
        }
        if (i == c.links()) break;
        length += c.rest[i];
        longest = std::max(longest, c.rest[i]);
      }
    }
    return false;
  }

 private:
  double energy() const { return taut::energy(simulation_.world()); }

  std::size_t index(const Connector& connector) const {
    return static_cast<std::size_t>(&connector - simulation_.world().connectors.data());
  }

  /// Where the particle, or one that it is joined with, is held by what no motion moves.
  std::optional<Vec3> held_place(const Joint::Particle& at, double time) const {
    const World& world = simulation_.world();
    const Joint* joint = find_joint(world, at.connector, at.particle);
    for (const Joint::Particle& one : joint ? joint->particles : std::vector{at}) {
      for (const Hold& hold : world.connectors[one.connector].holds) {
        if (hold.particle == one.particle && is_prescribed(world, hold.to)) {
          return hold_motion(world, hold.to, time).position;
        }
      }
    }
    return {};
  }

  /// The same across joints: whether no way along links between two places that are held is longer
  /// than they are apart.
  bool is_drawn_apart(double time) const {
    constexpr double kNear = 1e-3;  // of the way
    const World& world = simulation_.world();
    std::vector<std::uint32_t> leaders;
    find_leaders(world, leaders);
    struct Link {
      std::uint32_t a, b;
      double rest;
    };
    std::vector<Link> links;
    std::vector<std::pair<std::uint32_t, Vec3>> held;
    std::uint32_t first = 0;
    for (const Connector& c : world.connectors) {
      for (std::uint32_t i = 0; i < c.particles(); ++i) {
        if (i < c.links() && !c.stretches()) {
          links.push_back({leaders[first + i], leaders[first + i + 1], c.rest[i]});
        }
        const auto place = held_place({index(c), i}, time);
        if (place) held.emplace_back(leaders[first + i], *place);
      }
      first += static_cast<std::uint32_t>(c.particles());
    }
    for (const auto& [from, start] : held) {
      std::vector<double> way(leaders.size(), INFINITY);
      way[from] = 0;
      for (bool shorter = true; shorter;) {
        shorter = false;
        for (const Link& link : links) {
          for (const auto& [a, b] : {std::pair(link.a, link.b), std::pair(link.b, link.a)}) {
            if (!(way[a] + link.rest < way[b])) continue;
            way[b] = way[a] + link.rest;
            shorter = true;
          }
        }
      }
      for (const auto& [to, end] : held) {
        if (to != from && (end - start).norm() > (1 - kNear) * way[to]) return true;
      }
    }
    return false;
  }

  bool is_finite(const Snapshot& frame) const {
    const auto finite = [](const std::vector<Vec3>& places) {
      return std::ranges::all_of(places, [](const Vec3& v) { return v.allFinite(); });
    };
    const World& world = simulation_.world();
    return std::ranges::all_of(frame.connectors, finite) &&
           std::ranges::all_of(frame.bodies,
                               [](const Pose& p) {
                                 return p.position.allFinite() && p.rotation.coeffs().allFinite();
                               }) &&
           std::ranges::all_of(world.connectors, finite, &Connector::velocity);
  }

  /// A span may be as short as it likes, and what stretches as long.
  static double stretch(const World& world) {
    World links;
    double longest = 0;
    for (const Connector& c : world.connectors) {
      if (c.stretches()) continue;
      if (c.model == ConnectorModel::links) {
        links.connectors.push_back(c);
      } else {
        longest = std::max(longest, (c.position[1] - c.position[0]).norm() / c.length - 1);
      }
    }
    return std::max(longest, stretch_max(links));
  }

  double fastest() const {
    double speed = 0;
    for (const Connector& connector : simulation_.world().connectors) {
      for (const Vec3& v : connector.velocity) speed = std::max(speed, v.norm());
    }
    return speed;
  }

  /// A pin may take its place at once; one that stood on a link lets the link go straight, and what
  /// a method had stretched comes back, also by a cut.
  bool may_jump(int frame) const {
    const auto is_in = [&](double time) {
      return time * scene_.fps > frame - 1 && time * scene_.fps <= frame;
    };
    const auto jumps = [&](const TimedPin& pin) {
      return is_in(pin.until) || (pin.to && pin.over == 0 && is_in(pin.from));
    };
    return std::ranges::any_of(scene_.timeline.pins, jumps) ||
           (!claims_ && std::ranges::any_of(scene_.timeline.cuts, is_in, &TimedCut::time));
  }

  /// Whips and impacts have their speed between frames that are far apart, and what swings quickly
  /// its greatest: where the speeds at two frames do not account for the way between them, those of
  /// a run in parts of the frame must.
  void look_at_jump(const Snapshot& before, const Snapshot& now, double speed, int frame) {
    const double time = 1.0 / scene_.fps;
    const double near = error_ + 1e-3 * length_scale(scene_.world);
    const auto most = [&](double fastest, double during) {
      return during * (3 * fastest + scene_.world.gravity.norm() * during);
    };
    const double way = farthest(before, now);
    if (scene_.fps < 60 || way <= most(speed, time) + near) return;
    if (may_jump(frame) || is_at_full_length(frame * time) || end_is_inside()) return;
    // A method with steps of its own is looked at after each: shorter ones would be another run.
    const double own = step_of(method_.settings);
    const auto at = [&](int of_frame) { return of_frame / static_cast<double>(scene_.fps); };
    const StepTimes times(at(frame - 1), at(frame), own > 0 ? own : time / 64);
    Watch finer(scene_, method_);
    for (int first = 1; first < frame; ++first) finer.simulation_.advance_to(at(first));
    double accounted = near, last = finer.fastest();
    for (std::uint64_t part = 1; part <= times.count; ++part) {
      finer.simulation_.advance_to(part == times.count ? at(frame) : times.at(part));
      const double next = finer.fastest();
      accounted += most(std::max(last, next), times.dt);
      last = next;
    }
    if (way > accounted) tell("continuous", frame, way, accounted);
  }

  /// Whether what holds an end has drawn it into an obstacle that its connector touches: then no
  /// motion may exist.
  bool end_is_inside() const {
    const World& world = simulation_.world();
    for (const Obstacle& obstacle : world.obstacles) {
      const Pose frame = obstacle.frame(world.time).pose();
      for (const Connector& c : world.connectors) {
        if (!obstacle.touches(c.category)) continue;
        for (const Hold& hold : c.holds) {
          const Vec3& at = c.position[hold.particle];
          if (gap(obstacle, frame, at, c.radius).distance < 0) return true;
        }
      }
    }
    return false;
  }

  static double farthest(const Snapshot& a, const Snapshot& b) {
    double way = 0;
    for (std::size_t c = 0; c < a.connectors.size(); ++c) {
      for (std::size_t i = 0; i < a.connectors[c].size(); ++i) {
        way = std::max(way, (b.connectors[c][i] - a.connectors[c][i]).norm());
      }
    }
    return way;
  }

  /// Places that are off by the error change the potential energy by mass and gravity; velocities
  /// are off by the error times how fast links and bodies turn.
  void look_at_claims(int frame) {
    if (!claims_) return;
    const World& world = simulation_.world();
    const double most_stretched = stretch(world);
    if (!(most_stretched < kStretch) && !is_at_full_length(world.time)) {
      tell("stretch", frame, most_stretched, kStretch);
    }
    if (!closed_) return;
    double held = 0;  // J, that roundings of places put into links that stretch
    const double rounded = 1e-15 * length_scale(world);
    for (const Connector& c : world.connectors) {
      for (std::size_t i = 0; i < c.links(); ++i) {
        if (c.stretches()) held += c.sections[i].axial_stiffness / c.rest[i] * rounded * rounded;
        if (c.rest[i] > 0) {
          rate_ = std::max(rate_, (c.velocity[i + 1] - c.velocity[i]).norm() / c.rest[i]);
        }
      }
    }
    for (const Body& body : world.bodies) rate_ = std::max(rate_, body.spin.norm());
    const double velocity = error_ * rate_;
    const double resting = 1e-9 * length_scale(world);  // m/s, which are none
    momentum_ = std::max(momentum_, std::sqrt(2 * mass_ * kinetic_energy(world)));
    const double most = mass_ * world.gravity.norm() * error_ + momentum_ * velocity +
                        mass_ * velocity * velocity / 2 + 1e-9 * energy_scale(scene_.world) +
                        mass_ * resting * resting + held;
    const double gained = energy() - at_start_;
    if (!(gained <= most)) tell("energy", frame, gained, most);
  }

  void tell(const char* promise, int frame, double found, double expected) {
    const std::string start = std::string(promise) + '\t';
    if (broken_.find(start) != broken_.npos) return;
    broken_ +=
        fmt::format("{}frame {}: {:.3g}, expected at most {:.3g}\n", start, frame, found, expected);
  }

  const scenes::Scene& scene_;
  const MethodChoice& method_;
  Simulation simulation_;
  bool closed_, claims_;
  double error_;  // m
  double mass_;   // kg
  double at_start_;
  double rate_ = 0, momentum_ = 0;  // the greatest so far, rad/s and kg m/s
  std::vector<std::uint64_t> hashes_;
  std::string broken_;
};

}  // namespace taut::drawn
