#include "tests/drawn/promises.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "scenes/model/sandbox.h"
#include "scenes/reader/document.h"
#include "scenes/reader/reader.h"
#include "scenes/scene.h"
#include "sim/measure.h"
#include "sim/study/accuracy.h"
#include "sim/study/run.h"
#include "tests/bench/promise/reference.h"

namespace taut::drawn {
namespace {

constexpr double kPatience = 5;               // s of CPU time
constexpr std::size_t kMemory = 1024u << 20;  // bytes
constexpr double kTolerances = 3;             // that an error may have
constexpr double kTruthError = 1e-6;          // of the length: what the truth is taken to claim
constexpr double kStretch = 1e-6;             // of a link's length
constexpr double kReferenceTime = 4;          // s of CPU time

/// One run, frame by frame.
class Watch {
 public:
  Watch(const Scene& scene, const MethodChoice& method)
      : scene_(scene),
        simulation_(start(scene, method)),
        closed_(is_closed(scene.world) && scene.timeline.empty()),
        claims_(method.name == "direct" || method.name == "truth"),
        error_(kTolerances * (method.name == "direct" ? number(method.settings, "tolerance")
                                                      : kTruthError * length_scale(scene.world))),
        mass_(moving_mass(scene.world)),
        at_start_(energy()) {}

  /// The promises that it breaks, a line each.
  std::string look() {
    Snapshot before = simulation_.state();
    double speed = fastest();
    for (int frame = 1; frame <= scene_.frames(); ++frame) {
      simulation_.advance_to(frame / static_cast<double>(scene_.fps));
      const Snapshot now = simulation_.state();
      if (!is_finite(now)) return fmt::format("finite\tframe {}\n", frame);
      const double next = fastest();
      look_at_jump(before, now, std::max(speed, next), frame);
      look_at_claims(frame);
      before = now;
      speed = next;
      hash_ = (hash_ ^ state_hash(simulation_.world())) * 1099511628211u;
    }
    return broken_;
  }

  std::uint64_t hash() const { return hash_; }

  /// Whether two places that are held are as far apart at that time as the links between them
  /// reach, or a single link does not fit: then no motion may exist.
  bool is_at_full_length(double time) const {
    constexpr double kNear = 1e-3;  // of the length
    const World& world = simulation_.world();
    for (const Connector& c : world.connectors) {
      const Hold* before = nullptr;
      for (const Hold& hold : c.holds) {
        if (!is_prescribed(world, hold.to)) continue;
        if (const Hold* other = std::exchange(before, &hold)) {
          double length = 0;
          for (std::size_t i = other->particle; i < hold.particle; ++i) length += c.rest[i];
          const double apart = (hold_motion(world, hold.to, time).position -
                                hold_motion(world, other->to, time).position)
                                   .norm();
          if (apart > (1 - kNear) * length || hold.particle == other->particle + 1) return true;
        }
      }
    }
    return false;
  }

 private:
  double energy() const { return taut::energy(simulation_.world()); }

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

  /// A span may be as short as it likes.
  static double stretch(const World& world) {
    World links;
    double longest = 0;
    for (const Connector& c : world.connectors) {
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

  /// Whips and impacts have their speed between frames that are far apart.
  void look_at_jump(const Snapshot& before, const Snapshot& now, double speed, int frame) {
    if (scene_.fps < 60) return;
    const double time = 1.0 / scene_.fps;
    const double most = time * (3 * speed + scene_.world.gravity.norm() * time) + error_ +
                        1e-3 * length_scale(scene_.world);
    for (std::size_t c = 0; c < now.connectors.size(); ++c) {
      for (std::size_t i = 0; i < now.connectors[c].size(); ++i) {
        const double far = (now.connectors[c][i] - before.connectors[c][i]).norm();
        if (far > most) tell("continuous", frame, far, most);
      }
    }
  }

  /// Places that are off by the error change the potential energy by mass and gravity; velocities
  /// are off by the error times how fast links and bodies turn.
  void look_at_claims(int frame) {
    if (!claims_) return;
    const World& world = simulation_.world();
    if (const double most = stretch(world); !(most < kStretch)) {
      tell("stretch", frame, most, kStretch);
    }
    if (!closed_) return;
    for (const Connector& c : world.connectors) {
      for (std::size_t i = 0; i < c.links(); ++i) {
        if (c.rest[i] > 0) {
          rate_ = std::max(rate_, (c.velocity[i + 1] - c.velocity[i]).norm() / c.rest[i]);
        }
      }
    }
    for (const Body& body : world.bodies) rate_ = std::max(rate_, body.spin.norm());
    const double velocity = error_ * rate_;
    momentum_ = std::max(momentum_, std::sqrt(2 * mass_ * kinetic_energy(world)));
    const double most = mass_ * world.gravity.norm() * error_ + momentum_ * velocity +
                        mass_ * velocity * velocity / 2 + 1e-9 * energy_scale(scene_.world);
    const double gained = energy() - at_start_;
    if (!(gained <= most)) tell("energy", frame, gained, most);
  }

  void tell(const char* promise, int frame, double found, double expected) {
    const std::string start = std::string(promise) + '\t';
    if (broken_.find(start) != broken_.npos) return;
    broken_ +=
        fmt::format("{}frame {}: {:.3g}, expected at most {:.3g}\n", start, frame, found, expected);
  }

  const Scene& scene_;
  Simulation simulation_;
  bool closed_, claims_;
  double error_;  // m
  double mass_;   // kg
  double at_start_;
  double rate_ = 0, momentum_ = 0;  // the greatest so far, rad/s and kg m/s
  std::uint64_t hash_ = 14695981039346656037u;
  std::string broken_;
};

constexpr const char* kDiverged = "diverged\t";

std::string run_twice(const Scene& scene, const MethodChoice& method) {
  const bool claims = method.name == "direct" || method.name == "truth";
  Watch first(scene, method);
  try {
    const double start = thread_seconds();
    std::string broken = first.look();
    const double spent = thread_seconds() - start;
    if (spent > kPatience) broken += fmt::format("ends\ttook {:.1f} s\n", spent);
    Watch second(scene, method);
    second.look();
    if (first.hash() != second.hash()) broken += "same\tother bits\n";
    return broken;
  } catch (const Diverged& error) {
    // Among obstacles the truth does not find every motion, and says where it stops.
    const bool stops = method.name == "truth" && !scene.world.obstacles.empty();
    const bool excused = !claims || stops || first.is_at_full_length(error.time);
    return (excused ? kDiverged : "follows\t") + std::string(error.what()) + '\n';
  } catch (const BadIntervention& error) {
    return kDiverged + std::string(error.what()) + '\n';
  } catch (const std::exception& error) {
    return fmt::format("ends\t{}\n", error.what());
  }
}

/// How far `direct` is off, where that can be told.
std::string compare(const Scene& scene) {
  const Problem problem{scene.world, frame_times(scene.duration, scene.fps), scene.timeline};
  const double length = length_scale(scene.world);
  const promise::Reference reference = promise::make_reference(problem, length, kReferenceTime);
  if (!reference.usable()) return "unknown\t\n";
  const Settings settings = with_defaults(*find_method("direct"), scene.method.settings);
  const Run found = run(problem, {"direct", settings}, kPatience);
  const double most = kTolerances * number(settings, "tolerance");
  const auto distance = [](const Vec3& a, const Vec3& b, double) { return (a - b).norm(); };
  for (std::size_t k = 0; k < std::min(reference.frames.size(), found.frames.size()); ++k) {
    const double error = frame_error(found.frames[k], reference.frames[k], distance);
    if (!(error <= most)) {
      return fmt::format("error\tframe {}: {:.3g} m, expected at most {:.3g}, growth {:.3g}\n", k,
                         error, most, reference.growth);
    }
  }
  return {};
}

/// Whether the method says that it takes such a scene.
bool takes(const MethodInfo& method, const World& world) {
  const bool spans = std::ranges::any_of(
      world.connectors, [](const Connector& c) { return c.model == ConnectorModel::span; });
  return method.missing.empty() && method.name != "sdfast" && (method.follows_spans || !spans) &&
         (method.touches_obstacles || world.obstacles.empty());
}

/// Runs the work in a process of its own; the lines of what it returns.
std::vector<Broken> apart(const std::string& method, double cpu_time,
                          const std::function<std::string()>& work) {
  const SandboxLimits limits{kMemory, 1u << 20, cpu_time, 20 * cpu_time};
  const SandboxResult result = run_in_sandbox(limits, work);
  switch (result.end) {
    case SandboxResult::End::replied:
      break;
    case SandboxResult::End::no_time:
      return {{method, "ends", fmt::format("not within {} s", cpu_time)}};
    case SandboxResult::End::no_memory:
      return {{method, "ends", "not within 1 GB"}};
    default:
      return {{method, "ends", fmt::format("by a fault, status {}", result.status)}};
  }
  std::vector<Broken> broken;
  for (std::size_t at = 0; at < result.reply.size();) {
    const std::size_t tab = result.reply.find('\t', at), end = result.reply.find('\n', tab);
    broken.push_back(
        {method, result.reply.substr(at, tab - at), result.reply.substr(tab + 1, end - tab - 1)});
    at = end + 1;
  }
  return broken;
}

}  // namespace

Verdict check_promises(const std::string& text, const std::string& only) {
  Verdict verdict;
  std::optional<Scene> scene;
  try {
    scene = read_scene(parse_document("drawn.toml", text), false);
  } catch (const BadScene& error) {
    verdict.refusal = error.what();
    return verdict;
  }
  const auto add = [&](std::vector<Broken> found) {
    for (Broken& broken : found) {
      if (broken.promise == "diverged") {
        ++verdict.diverged;
      } else if (broken.promise == "unknown") {
        --verdict.compared;
      } else {
        verdict.broken.push_back(std::move(broken));
      }
    }
  };
  for (const MethodInfo& method : methods()) {
    if (!takes(method, scene->world) || (!only.empty() && method.name != only)) continue;
    MethodChoice choice{std::string(method.name), {}};
    if (method.name == scene->method.name) choice = scene->method;
    choice.settings = with_defaults(method, choice.settings);
    ++verdict.runs;
    add(apart(choice.name, 2 * kPatience, [&] { return run_twice(*scene, choice); }));
  }
  if (scene->method.name == "direct" && (only.empty() || only == "direct") &&
      takes(*find_method("truth"), scene->world)) {
    ++verdict.compared;
    add(apart("direct", 2 * (kReferenceTime + kPatience), [&] { return compare(*scene); }));
  }
  return verdict;
}

}  // namespace taut::drawn
