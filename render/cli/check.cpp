#include "render/cli/check.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <memory>
#include <optional>
#include <set>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "render/base/atomic_file.h"
#include "render/base/child.h"
#include "render/chart/table.h"
#include "render/export/csv.h"
#include "render/film/caption.h"
#include "render/options/method_options.h"
#include "render/options/needs.h"
#include "render/options/scene_options.h"
#include "render/plan/plan.h"
#include "render/program/command.h"
#include "render/program/output.h"
#include "render/program/program.h"
#include "scenes/files/error.h"
#include "scenes/format/format.h"
#include "scenes/load/default_stage.h"
#include "scenes/load/faults.h"
#include "scenes/load/load_scene.h"
#include "scenes/load/plan_file.h"
#include "scenes/scene/scene.h"
#include "sim/contact/capsule.h"
#include "sim/evaluation/run.h"
#include "sim/measure/measure.h"
#include "sim/motion/printable.h"
#include "sim/motion/stop.h"
#include "sim/run/error_estimate.h"
#include "sim/run/method.h"

namespace taut::cli {
namespace {

constexpr std::size_t kMostStates = 5e7;  // bytes, of all that are sent
constexpr double kMarked = 2e-3;          // s of CPU time between two marks
constexpr double kUnsaid = 0.02;          // s of CPU time, from the last mark to the end, at most
constexpr double kFirstPart = 0x1p-10;    // of a frame
constexpr double kFirstFrame = 0.5;       // of the CPU time; one that takes more is run in parts

/// Calls visit(number) for every number of a state, in order.
template <typename State, typename Visit>
void each_number(State& state, Visit visit) {
  visit(state.time);
  for (auto& particles : state.connectors)
    for (auto& at : particles)
      for (Eigen::Index k = 0; k < 3; ++k) visit(at[k]);
  for (auto& body : state.bodies) {
    for (Eigen::Index k = 0; k < 3; ++k) visit(body.position[k]);
    for (Eigen::Index k = 0; k < 4; ++k) visit(body.rotation.coeffs()[k]);
  }
}

std::string bytes_of(const Snapshot& state) {
  std::string bytes;
  each_number(state, [&](double number) {
    bytes.append(reinterpret_cast<const char*>(&number), sizeof number);
  });
  return bytes;
}

/// Back into a state of the same parts.
std::optional<Snapshot> state_of(std::string_view bytes, const Snapshot& shape) {
  Snapshot state = shape;
  bool enough = true;
  each_number(state, [&](double& number) {
    enough = enough && bytes.size() >= sizeof number;
    if (!enough) return;
    std::memcpy(&number, bytes.data(), sizeof number);
    bytes.remove_prefix(sizeof number);
  });
  if (!enough || !bytes.empty()) return std::nullopt;
  return state;
}

/// The parts that all states of the scene's simulation have.
Snapshot shape_of(const scenes::Scene& scene) {
  return snapshot(divided(scene.world, scene.timeline));
}

/// The run of taut simulate, as far as its cost goes.
class Run {
 public:
  explicit Run(const scenes::Scene& scene)
      : simulation_(scenes::start(scene)),
        estimate_(scene.world, scene.method.name, scene.method.settings, scene.timeline),
        balance_(scene.timeline) {}

  /// To a frame, which is measured and written.
  void to_frame(double time) {
    to(time);
    const World& world = std::as_const(simulation_).world();
    measured_ += balance_.next(world) + stretch_max(world) + contact::penetration_max(world);
    written_ += exporting::csv_row(simulation_.state()).size();
  }
  /// To a time between frames.
  void to(double time) {
    simulation_.advance_to(time);
    estimate_.follow(simulation_);
  }
  const Simulation& simulation() const { return simulation_; }

 private:
  Simulation simulation_;
  ErrorEstimate estimate_;
  study::EnergyBalance balance_;
  double measured_ = 0;
  std::size_t written_ = 0;
};

/// Marks of a run; what is done for them does not count as the run's.
class Marks {
 public:
  explicit Marks(const render::Say& say) : say_(say) {}

  void add(double time, bool always) {
    const double now = thread_seconds();
    if (!always && now - last_ < kMarked) return;
    last_ = now;
    tell(say_, Said::mark, {time, now - aside_, now});
  }
  void add_state(const Simulation& simulation) {
    const double before = thread_seconds();
    const std::string bytes = bytes_of(simulation.state());
    sent_ += bytes.size();
    if (sent_ <= kMostStates) tell(say_, Said::state, bytes);
    aside_ += thread_seconds() - before;
  }

 private:
  const render::Say& say_;
  double last_ = 0, aside_ = 0;
  std::size_t sent_ = 0;
};

/// Of a scene whose first frame takes too long: parts of that frame that double, whole steps where
/// all steps are equal.
void run_parts(const scenes::Scene& scene, const render::Say& say) {
  tell(say, Said::again, {thread_seconds()});
  Marks marks(say);
  Run run(scene);
  marks.add(0, true);
  const double frame = 1.0 / scene.fps, step = step_of(with_defaults(scene.method));
  double part = step > 0 ? step : kFirstPart * frame;
  for (double time = part; time < frame; time += part) {
    run.to(time);
    marks.add(time, true);
    part *= 2;
  }
}

void run_frames(const scenes::Scene& scene, double seconds, const render::Say& say) {
  Marks marks(say);
  Run run(scene);
  marks.add(0, true);
  const int every = scenes::frames_between_looks(scene);
  for (int frame = 0; frame < scene.frames(); ++frame) {
    const double time = static_cast<double>(frame) / scene.fps;
    if (frame <= 1) {
      try {
        const WorkLimit limit({.cpu_time = kFirstFrame * seconds});
        run.to_frame(time);
      } catch (const OverLimit&) {
        return run_parts(scene, say);
      }
    } else {
      run.to_frame(time);
    }
    if (frame % every == 0) marks.add_state(run.simulation());
    marks.add(time, frame == 1);
  }
  marks.add(end_of(scene), true);
}

}  // namespace

double end_of(const scenes::Scene& scene) {
  return static_cast<double>(scene.frames() - 1) / scene.fps;
}

Piece run_piece(const scenes::Scene& scene, double seconds) {
  const render::Bounded bounded =
      render::run_bounded({seconds, kCopyMemory}, [&](const render::Say& say) {
        try {
          run_frames(scene, seconds, say);
        } catch (const Diverged& error) {  // the run ends there as well
          tell(say, Said::diverged, error.what());
        } catch (const BadIntervention& error) {
          tell(say, Said::diverged, error.what());
        }
      });
  Piece piece;
  piece.next = 1.0 / scene.fps;
  const Snapshot shape = shape_of(scene);
  double used = 0;
  each_record(bounded.said, [&](Said what, std::string_view bytes) {
    if (what == Said::state) {
      if (auto state = state_of(bytes, shape)) piece.states.push_back(std::move(*state));
    } else if (what == Said::diverged) {
      piece.over = true;
      piece.diverged = bytes;
    } else if (what == Said::again) {
      piece.in_parts = true;
      piece.first_frame = numbers_of(bytes).front() - used;
      piece.marks.clear();
    } else {
      const std::vector<double> numbers = numbers_of(bytes);
      piece.marks.push_back({numbers[0], numbers[1]});
      used = numbers[2];
    }
  });
  if (bounded.end == render::Bounded::End::no_time) {
    piece.unfinished = std::max(seconds - kUnsaid - used, 0.0);
  }
  if (piece.in_parts) {
    const double step = step_of(with_defaults(scene.method));
    piece.next = piece.until() > 0 ? piece.until() : step > 0 ? step : kFirstPart / scene.fps;
  }
  return piece;
}

namespace {

constexpr double kMostMemory = 1e9;  // bytes; of what takes more, no piece is run

/// The cost of a simulated second at the end of the piece, in CPU seconds.
double rate_at_end(const std::vector<Mark>& marks) {
  const Mark& last = marks.back();
  const double half = (marks.front().cpu + last.cpu) / 2;
  auto from = std::ranges::find_if(marks, [&](const Mark& mark) { return mark.cpu > half; });
  if (from != marks.begin()) --from;
  return last.time > from->time ? (last.cpu - from->cpu) / (last.time - from->time) : 0;
}

}  // namespace

std::string why_not_tried(const scenes::Scene& scene) {
  return options::simulation_needs(scene).memory > kMostMemory ? "takes too much memory to be tried"
                                                               : "";
}

RunTime time_of_run(const scenes::Scene& scene, double started, const Piece& piece) {
  RunTime result;
  const double end = end_of(scene);
  if (piece.marks.empty()) {  // not even its start
    result.seconds = result.least = started + piece.unfinished;
    result.at_least = true;
    return result;
  }
  const Mark& last = piece.marks.back();
  if (piece.over || last.time >= end) {
    const double run = started + last.cpu;
    return {run, run, run, last.time, true, piece.over, false, ""};
  }
  result.simulated = last.time;
  const double left = end - last.time, tried = started + last.cpu + piece.unfinished;
  // What came after the last mark was not enough for the next one.
  const double seen = std::max(piece.marks.size() > 1 ? rate_at_end(piece.marks) : 0,
                               piece.unfinished / piece.next);
  const double average =
      (last.cpu + piece.unfinished - piece.marks.front().cpu) / (last.time + piece.next);
  result.least = tried + std::min(average, seen) * left;
  result.most = tried + std::max(average, seen) * left;
  // The end of the piece tells more of what follows than its beginning.
  constexpr double kEnd = 0.75;
  result.seconds = tried + std::pow(seen, kEnd) * std::pow(average, 1 - kEnd) * left;
  if (last.time == 0) {  // not even a step
    const double step = std::max(piece.unfinished, piece.first_frame);
    const double steps = std::max(options::steps_per_frame(scene), 1.0);
    result.seconds = result.least = tried + step * steps * (scene.frames() - 1);
    result.at_least = true;
  } else if (piece.in_parts && !(step_of(with_defaults(scene.method)) > 0)) {
    // Steps begin far shorter than they become. A frame takes one at least, and so did every part.
    const double parts = static_cast<double>(piece.marks.size());
    const double step = std::max(piece.unfinished, (last.cpu - piece.marks.front().cpu) / parts);
    result.seconds = result.least = tried + step * left * scene.fps;
    result.at_least = true;
  }
  return result;
}

std::string text_of(const RunTime& time) {
  if (!time.unknown.empty()) return "a time that is not known: it " + time.unknown;
  const std::string text = options::time_text(time.seconds);
  if (time.diverges)
    return fmt::format("{}, until it fails behind the frame at {:.3g} s", text, time.simulated);
  if (time.whole) return text;
  if (time.simulated == 0) {
    return fmt::format(
        "more than {}; how much more is not known, as the first step takes longer than a check may",
        text);
  }
  const std::string by = fmt::format("as its first {:.2g} s tell", time.simulated);
  if (time.at_least) return fmt::format("{} or more, {}", text, by);
  constexpr double kSame = 2;
  if (time.most < kSame * time.least) return fmt::format("{}, {}", text, by);
  return fmt::format("{} to {}, {}", options::time_text(time.least), options::time_text(time.most),
                     by);
}

namespace {

constexpr std::string_view kMethod = "xpbd";  // equal steps, each of little work
constexpr double kShortest = 1e-2;            // s of CPU time, of a look
constexpr double kLeastTime = 5e-3;           // s; less is of no account
constexpr double kDearer = 20;                // times, at least, to be worth a word
constexpr double kApart = 0.01;               // of the longest connector
constexpr double kMoved = 0.1;                // of that, at least: still, all methods agree

/// RMS distance (m) of all particles and all bodies' origins.
double distance(const Snapshot& a, const Snapshot& b) {
  double squares = 0, count = 0;
  const auto add = [&](const Vec3& one, const Vec3& other) {
    squares += (one - other).squaredNorm();
    ++count;
  };
  for (std::size_t c = 0; c < a.connectors.size(); ++c)
    for (std::size_t i = 0; i < a.connectors[c].size(); ++i)
      add(a.connectors[c][i], b.connectors[c][i]);
  for (std::size_t k = 0; k < a.bodies.size(); ++k) add(a.bodies[k].position, b.bodies[k].position);
  return count > 0 ? std::sqrt(squares / count) : 0;
}

/// The run by another method up to the piece's last state: how far it is from the piece, and its
/// cost for the whole scene. Nothing where it does not get there.
std::optional<Cheaper> compared(const scenes::Scene& scene, const MethodChoice& method,
                                const Piece& piece, double seconds) {
  const int every = scenes::frames_between_looks(scene);
  const render::Bounded bounded =
      render::run_bounded({seconds, kCopyMemory}, [&](const render::Say& say) {
        Simulation simulation = scenes::start(scene, method);
        double apart = 0;
        for (std::size_t i = 0; i < piece.states.size(); ++i) {
          simulation.advance_to(static_cast<double>(i) * every / scene.fps);
          apart = std::max(apart, distance(simulation.state(), piece.states[i]));
        }
        tell(say, Said::mark, {std::as_const(simulation).world().time, thread_seconds(), apart});
      });
  std::optional<Cheaper> found;
  each_record(bounded.said, [&](Said, std::string_view bytes) {
    const std::vector<double> numbers = numbers_of(bytes);
    if (numbers[0] > 0) {
      found = {method, numbers[1] / numbers[0] * end_of(scene), numbers[2], numbers[0]};
    }
  });
  return found;
}

}  // namespace

std::optional<Cheaper> cheaper_method(const scenes::Scene& scene, const RunTime& time,
                                      double started, const Piece& piece, double seconds) {
  const MethodInfo* info = find_method(kMethod);
  if (scene.method.name == kMethod || !info || !follows(*info, scene.world) || piece.over ||
      time.at_least || time.least < kDearer * kLeastTime) {
    return std::nullopt;
  }
  const double length = length_scale(scene.world);
  const bool moves = std::ranges::any_of(piece.states, [&](const Snapshot& state) {
    return distance(state, piece.states.front()) >= kMoved * length;
  });
  if (!moves) return std::nullopt;
  MethodChoice method{std::string(kMethod), {}};
  const double frame = 1.0 / scene.fps;
  double most = seconds;
  // With shorter and shorter steps, as long as it is cheap.
  const double own = step_of(with_defaults(*info, {}, scene.world));
  for (double steps = std::ceil(frame / own);; steps *= 4) {
    method.settings["step"] = frame / steps;
    const double before = render::children_seconds();
    auto found = compared(scene, method, piece, most);
    if (!found) return std::nullopt;
    found->seconds += started;
    if (!(kDearer * found->seconds < time.least)) return std::nullopt;
    if (found->apart <= kApart * length) return found;
    most -= render::children_seconds() - before;
    if (most < kShortest) return std::nullopt;
  }
}

std::string text_of(const Cheaper& cheaper, const RunTime& time, const scenes::Scene& scene) {
  const double step = number(cheaper.method.settings, "step");
  return fmt::format(
      "{0} takes {1}; --method {2} --step {3:.6g} takes {4} and is within {5:.2g} mm of it "
      "({6:.2g}% "
      "of the length) until {7:.2g} s, as far as they were compared",
      scene.method.name, options::time_text(time.seconds), cheaper.method.name, step,
      options::time_text(cheaper.seconds), 1e3 * cheaper.apart,
      100 * cheaper.apart / length_scale(scene.world), cheaper.until);
}

std::string what_helps(const scenes::Scene& scene, const RunTime& time) {
  constexpr double kLong = 60;  // s
  if (!time.unknown.empty() || time.least < kLong) return {};
  const Settings settings = with_defaults(scene.method);
  const auto value = [&](const char* name) { return std::get<double>(settings.at(name)); };
  std::vector<std::string> ways;
  if (settings.contains("tolerance"))
    ways.push_back(fmt::format("a tolerance above {:.3g} m", value("tolerance")));
  if (step_of(settings) > 0) ways.push_back(fmt::format("a step above {:.3g} s", value("step")));
  std::size_t particles = 0;
  for (const Connector& connector : scene.world.connectors) particles += connector.particles();
  if (particles > 0) ways.push_back(fmt::format("fewer particles than {}", particles));
  return fmt::format(
      "{} takes {} or more; what may shorten that: {} (less accurate), --no-estimate (no estimate "
      "of the error)",
      scene.method.name, options::time_text(time.least), fmt::join(ways, ", "));
}

}  // namespace taut::cli

namespace taut::cli::check_command {
namespace {

/// Particles that are joined with others, as connector and number.
using Joined = std::set<std::pair<std::size_t, std::size_t>>;

Joined joined_particles(const World& world) {
  Joined found;
  for (const Joint& joint : world.joints) {
    for (const auto& [connector, particle] : joint.particles) found.emplace(connector, particle);
  }
  return found;
}

std::string held_by(const World& world, const Connector& connector, std::size_t particle) {
  for (const Hold& hold : connector.holds) {
    if (hold.particle != particle) continue;
    if (hold.to.kind == Attachment::Kind::fixed) return "a fixed point";
    if (hold.to.kind == Attachment::Kind::path) return "a path";
    return world.bodies[hold.to.body].name;
  }
  return "nothing";
}

std::string ends_text(const World& world, std::size_t index, const Joined& joined) {
  const Connector& connector = world.connectors[index];
  const auto end = [&](std::size_t particle) -> std::string {
    const std::string holder = held_by(world, connector, particle);
    return holder == "nothing" && joined.contains({index, particle}) ? "a joint" : holder;
  };
  const std::string first = end(0), last = end(connector.particles() - 1);
  return first == "nothing" && last == "nothing" ? "free"
                                                 : fmt::format("held by {} and {}", first, last);
}

/// The connector's material, where it is more than rigid links.
std::string material_text(const Connector& connector) {
  if (connector.sections.empty()) return "";
  const Section& first = connector.sections.front();
  std::string text;
  if (connector.stretches()) text += fmt::format(", EA {:.6g} N", first.axial_stiffness);
  if (first.bending_stiffness > 0)
    text += fmt::format(", EI {:.6g} N m^2", first.bending_stiffness);
  if (first.twisting_stiffness > 0)
    text += fmt::format(", GJ {:.6g} N m^2", first.twisting_stiffness);
  if (connector.drag.across > 0 || connector.drag.along > 0) {
    text +=
        fmt::format(", drag {} across and {} along", connector.drag.across, connector.drag.along);
  }
  return text;
}

/// A net's connectors from `first` to before `last`.
std::string net_text(const World& world, std::size_t first, std::size_t last) {
  const auto& all = world.connectors;
  double shortest = all[first].length, longest = shortest, mass = 0;
  std::size_t particles = 0, held = 0;
  for (std::size_t c = first; c < last; ++c) {
    shortest = std::min(shortest, all[c].length);
    longest = std::max(longest, all[c].length);
    mass += all[c].mass;
    particles += all[c].particles();
    held += all[c].holds.size();
  }
  const auto joints = std::ranges::count_if(world.joints, [&](const Joint& joint) {
    return joint.particles.front().connector >= first && joint.particles.front().connector < last;
  });
  const std::string lengths = shortest == longest
                                  ? fmt::format("{:.6g} m", shortest)
                                  : fmt::format("{:.6g} to {:.6g} m", shortest, longest);
  return fmt::format("net {}: {} cords of {}, {:.6g} kg, {} particles{}, {} joints, {} held",
                     scenes::written_name(all[first].name), last - first, lengths, mass, particles,
                     material_text(all[first]), joints, held);
}

}  // namespace

std::vector<std::string> connector_lines(const World& world) {
  const Joined joined = joined_particles(world);
  const auto& all = world.connectors;
  const auto words = [&](std::size_t c) {
    return fmt::format("{} m, {:.6g} kg, {} particles{}, {}", all[c].length, all[c].mass,
                       all[c].particles(), material_text(all[c]), ends_text(world, c, joined));
  };
  std::vector<std::string> lines;
  for (std::size_t first = 0, last = 0; first < all.size(); first = last) {
    const std::string_view name = scenes::written_name(all[first].name);
    last = first + 1;
    if (all[first].name.ends_with("#1")) {
      while (last < all.size() && scenes::written_name(all[last].name) == name) ++last;
      lines.push_back(net_text(world, first, last));
      continue;
    }
    const std::string text = words(first);
    while (last < all.size() && scenes::written_name(all[last].name) == name && words(last) == text)
      ++last;
    lines.push_back(last == first + 1 ? fmt::format("connector {}: {}", all[first].name, text)
                                      : fmt::format("connectors {} to {}: each {}", all[first].name,
                                                    all[last - 1].name, text));
  }
  return lines;
}

program::Json material_json(const Connector& connector) {
  const Section& first = connector.sections.front();
  program::Json json;
  json["axial_stiffness_n"] =
      connector.stretches() ? program::Json(first.axial_stiffness) : program::Json();
  json["bending_stiffness_n_m2"] = first.bending_stiffness;
  json["twisting_stiffness_n_m2"] = first.twisting_stiffness;
  json["drag"] = {{"across", connector.drag.across}, {"along", connector.drag.along}};
  return json;
}

}  // namespace taut::cli::check_command

namespace taut::cli {
namespace {

std::vector<std::string> names_of(Features some) {
  std::vector<std::string> names;
  for (std::size_t f = 0; f < kFeatureCount; ++f) {
    const auto feature = static_cast<Feature>(f);
    if (some.has(feature)) names.emplace_back(name(feature));
  }
  return names;
}

std::string within(const Apart& apart) {
  return apart.within == Apart::Within::world ? "a scene" : "one connector";
}

}  // namespace

std::string features_as_markdown() {
  chart::Table follows{{"feature"}, {}};
  for (const MethodInfo& method : all_methods()) {
    follows.columns.push_back(fmt::format("`{}`", method.name));
  }
  for (std::size_t f = 0; f < kFeatureCount; ++f) {
    const auto feature = static_cast<Feature>(f);
    std::vector<std::string>& row = follows.rows.emplace_back();
    row.emplace_back(name(feature));
    for (const MethodInfo& method : all_methods()) {
      row.emplace_back(method.abilities.follows.has(feature) ? "yes" : "");
    }
  }
  chart::Table apart{{"method", "does not follow", "together with", "in"}, {}};
  for (const MethodInfo& method : all_methods()) {
    for (const Apart& entry : method.abilities.apart) {
      const Features both = method.abilities.follows;
      apart.rows.push_back({fmt::format("`{}`", method.name),
                            fmt::format("{}", fmt::join(names_of(entry.one & both), ", ")),
                            fmt::format("{}", fmt::join(names_of(entry.other & both), ", ")),
                            within(entry)});
    }
  }
  return chart::to_markdown(follows) + "\n" + chart::to_markdown(apart);
}

namespace check_command {
namespace {

struct Options {
  options::SceneOptions inputs;
  bool schema = false, features = false;
  std::vector<std::string> plans;
};

constexpr int kSamples = 4;      // per pixel, as taut render takes them
constexpr double kWhole = 1;     // s of CPU time, of the whole check
constexpr double kLeast = 0.25;  // s of CPU time, whatever reading the scene takes
// Of what reading leaves of it.
constexpr double kPiece = 0.84;   // a piece of the run
constexpr double kCheaper = 0.1;  // a cheaper method, to compare with
constexpr double kLook = 0.06;    // the camera and what it shows, at least

constexpr double kLookedAt = 1e9;  // bytes; what takes more is not simulated for a look

/// What is known of a scene.
struct Known {
  scenes::Scene scene;
  bool staged = false;  // its file has a stage
  RunTime time;
  std::optional<Cheaper> cheaper;
  std::vector<std::string> warnings;
};

std::size_t triangles(const scenes::Model& model) {
  std::size_t count = 0;
  for (const scenes::Mesh& mesh : model.meshes) count += mesh.indices.size() / 3;
  return count;
}

std::string_view kind_of(const Obstacle& obstacle) {
  static constexpr std::array<std::string_view, 5> kKinds{"plane", "sphere", "capsule", "cylinder",
                                                          "box"};
  return kKinds[static_cast<std::size_t>(obstacle.shape.kind)];
}

/// The connectors and bodies that pass through an obstacle; of copies the first.
std::vector<std::string> ignored_by(const Obstacle& obstacle, const World& world) {
  std::vector<std::string> names;
  for (const Connector& connector : world.connectors)
    if (!obstacle.touches(connector.category) && !scenes::is_numbered(connector.name))
      names.push_back(connector.name);
  for (const Body& body : world.bodies)
    if (!obstacle.touches(body.capsule.category)) names.push_back(body.name);
  return names;
}

/// Whether the body is there only to show an obstacle on a path.
bool shows_obstacle(const World& world, const Body& body) {
  return std::ranges::any_of(world.obstacles, [&](const Obstacle& obstacle) {
    return obstacle.path && obstacle.name == body.name && obstacle.path == body.path;
  });
}

/// The models that the stage draws, each with its use.
std::vector<std::pair<std::string, const scenes::Model*>> models(const scenes::Scene& scene) {
  std::vector<std::pair<std::string, const scenes::Model*>> list;
  const scenes::Stage& stage = *scene.stage;
  for (const auto& model : stage.scenery) list.emplace_back("scenery", model.get());
  for (std::size_t i = 0; i < stage.body_models.size(); ++i) {
    if (const scenes::Model* model = stage.body_models[i].get()) {
      list.emplace_back("body " + scene.world.bodies[i].name, model);
    }
  }
  for (const auto& model : stage.characters) list.emplace_back("character", model.get());
  return list;
}

/// Adds a member whose name is new: looking whether it is takes a pass over all others.
void append(program::Json& object, const std::string& name, program::Json member) {
  using Members = program::Json::object_t::Container;
  static_cast<Members&>(object.get_ref<program::Json::object_t&>())
      .emplace_back(name, std::move(member));
}

program::Json needs_json(const options::Needs& needs, const RunTime& run, double more) {
  program::Json json = {{"memory_bytes", std::round(needs.memory)},
                        {"disk_bytes", std::round(needs.disk)}};
  json["time_s"] = run.unknown.empty() ? program::Json(run.seconds + more) : program::Json(nullptr);
  json["measured_until_s"] = run.simulated;
  json["at_least"] = run.at_least;
  json["fails"] = run.diverges;
  const bool ranges = run.unknown.empty() && !run.at_least;
  json["least_s"] = ranges ? program::Json(run.least + more) : program::Json(nullptr);
  json["most_s"] = ranges ? program::Json(run.most + more) : program::Json(nullptr);
  return json;
}

program::Json cheaper_json(const Cheaper& cheaper) {
  return {{"method", cheaper.method.name},
          {"settings", options::settings_json(with_defaults(cheaper.method))},
          {"time_s", cheaper.seconds},
          {"apart_m", cheaper.apart},
          {"apart_until_s", cheaper.until}};
}

/// The time (s) of drawing the clip, without simulating it.
double drawing_time(const scenes::Scene& scene, const options::Needs& clip) {
  return clip.time - options::simulation_needs(scene).time;
}

program::Json as_json(const Known& known, int threads) {
  const scenes::Scene& scene = known.scene;
  program::Json json = {
      {"scene", scene.file.string()},          {"title", scene.title}, {"warnings", known.warnings},
      {"duration_s", scene.duration},          {"fps", scene.fps},     {"frames", scene.frames()},
      {"size_px", {scene.width, scene.height}}};
  json["method"] = scene.method.name;
  json["settings"] = options::settings_json(with_defaults(scene.method));
  if (const double steps = options::steps_per_frame(scene); steps > 0)
    json["steps_per_frame"] = std::uint64_t(steps);
  json["bodies"] = program::Json::object();
  for (const Body& body : scene.world.bodies) {
    if (shows_obstacle(scene.world, body)) continue;
    append(json["bodies"], body.name,
           {{"driven", body.driven()}, {"mass_kg", body.mass_properties.mass}});
  }
  json["connectors"] = program::Json::object();
  for (const Connector& connector : scene.world.connectors) {
    program::Json one = {{"length_m", connector.length},
                         {"mass_kg", connector.mass},
                         {"particles", connector.particles()}};
    if (!connector.sections.empty()) one["material"] = material_json(connector);
    append(json["connectors"], connector.name, std::move(one));
  }
  json["joints"] = scene.world.joints.size();
  json["pulleys"] = program::Json::object();
  for (const Pulley& p : scene.world.pulleys)
    append(json["pulleys"], p.name,
           {{"inertia_kg", p.inertia}, {"friction", p.friction}, {"bearing", p.bearing}});
  json["obstacles"] = program::Json::object();
  for (const Obstacle& obstacle : scene.world.obstacles) {
    append(json["obstacles"], obstacle.name,
           {{"shape", kind_of(obstacle)},
            {"moves", obstacle.path != nullptr},
            {"friction", obstacle.kinetic_friction},
            {"static_friction", obstacle.static_friction},
            {"restitution", obstacle.restitution},
            {"ignores", ignored_by(obstacle, scene.world)}});
  }
  json["touching"] = program::Json::array();
  for (const BodyPair& pair : scene.world.pairs) {
    json["touching"].push_back(
        {{"bodies", {scene.world.bodies[pair.a].name, scene.world.bodies[pair.b].name}},
         {"friction", pair.kinetic_friction},
         {"static_friction", pair.static_friction},
         {"restitution", pair.restitution}});
  }
  for (const BeadPair& pair : scene.world.bead_pairs) {
    json["touching"].push_back({{"connector", scene.world.connectors[pair.connector].name},
                                {"body", scene.world.bodies[pair.body].name},
                                {"friction", pair.kinetic_friction},
                                {"static_friction", pair.static_friction},
                                {"restitution", pair.restitution}});
  }
  for (const ConnectorPair& pair : scene.world.connector_pairs) {
    json["touching"].push_back({{"connector", scene.world.connectors[pair.a].name},
                                {"other_connector", scene.world.connectors[pair.b].name},
                                {"friction", pair.kinetic_friction},
                                {"static_friction", pair.static_friction},
                                {"restitution", pair.restitution}});
  }
  if (scene.stage) json["clip_frames"] = std::uint64_t(options::clip_length(scene));
  json["pins"] = scene.timeline.pins.size();
  json["cuts"] = scene.timeline.cuts.size();
  json["simulate"] = needs_json(options::simulation_needs(scene), known.time, 0);
  if (scene.stage) {
    const options::Needs clip =
        options::clip_needs(scene, options::clip_length(scene), kSamples, threads);
    json["render"] = needs_json(clip, known.time, drawing_time(scene, clip));
  }
  json["cheaper"] = known.cheaper ? cheaper_json(*known.cheaper) : program::Json(nullptr);
  json["stage"] = known.staged;
  json["models"] = program::Json::array();
  if (!scene.stage) return json;
  for (const auto& [use, model] : models(scene)) {
    json["models"].push_back({{"use", use},
                              {"name", model->name},
                              {"triangles", triangles(*model)},
                              {"bones", model->bones.size()}});
  }
  return json;
}

/// Connectors that touch bodies and each other, in lines; copies and the cords of a net in one.
std::vector<std::string> pairs_with_connectors(const World& world) {
  std::vector<std::string> lines;
  for (const BeadPair& pair : world.bead_pairs) {
    const std::string& name = world.connectors[pair.connector].name;
    std::string text = fmt::format("beads of {} and body {} touch: friction {}, restitution {}",
                                   scenes::written_name(name), world.bodies[pair.body].name,
                                   pair.kinetic_friction, pair.restitution);
    if (std::ranges::find(lines, text) == lines.end()) lines.push_back(std::move(text));
  }
  for (const ConnectorPair& pair : world.connector_pairs) {
    const std::string_view a = scenes::written_name(world.connectors[pair.a].name),
                           b = scenes::written_name(world.connectors[pair.b].name);
    std::string text = fmt::format("{}: friction {}, restitution {}",
                                   a == b ? fmt::format("{} touches itself", a)
                                          : fmt::format("connectors {} and {} touch", a, b),
                                   pair.kinetic_friction, pair.restitution);
    if (std::ranges::find(lines, text) == lines.end()) lines.push_back(std::move(text));
  }
  return lines;
}

std::string as_text(const Known& known, int threads) {
  const scenes::Scene& scene = known.scene;
  const std::vector<std::string>& warnings = known.warnings;
  std::string text;
  const auto line = [&text](const std::string& words) { text += printable(words) + '\n'; };
  const World& world = scene.world;
  line(fmt::format("{}: {} s, {} frames at {} per second", scene.title, scene.duration,
                   scene.frames(), scene.fps));
  const double steps = options::steps_per_frame(scene);
  line(fmt::format("method {}{} ({})", scene.method.name,
                   steps > 0 ? fmt::format(", {:.0f} steps a frame", steps) : "",
                   options::settings_text(with_defaults(scene.method))));
  for (const Body& body : world.bodies) {
    if (shows_obstacle(world, body)) continue;
    line(fmt::format("body {}: {:.6g} kg, {}", body.name, body.mass_properties.mass,
                     body.driven() ? "driven" : "free"));
  }
  for (const std::string& connector : connector_lines(world)) line(connector);
  if (!world.joints.empty()) line(fmt::format("joints: {}", world.joints.size()));
  for (const Pulley& pulley : world.pulleys)
    line(fmt::format("pulley {}: inertia {} kg, friction {}, of its bearing {}", pulley.name,
                     pulley.inertia, pulley.friction, pulley.bearing));
  for (const Obstacle& obstacle : world.obstacles) {
    const std::vector<std::string> names = ignored_by(obstacle, world);
    line(fmt::format("obstacle {}: {}{}, friction {}, restitution {}{}{}", obstacle.name,
                     kind_of(obstacle), obstacle.path ? " on a path" : "",
                     obstacle.kinetic_friction, obstacle.restitution,
                     names.empty() ? "" : ", ignores ", fmt::join(names, ", ")));
  }
  for (const BodyPair& pair : world.pairs) {
    line(fmt::format("bodies {} and {} touch: friction {}, restitution {}",
                     world.bodies[pair.a].name, world.bodies[pair.b].name, pair.kinetic_friction,
                     pair.restitution));
  }
  for (const std::string& pair : pairs_with_connectors(world)) line(pair);
  for (const TimedPin& pin : scene.timeline.pins) {
    line(fmt::format("pin: {} at {} m, from {} s {}", world.connectors[pin.connector].name,
                     pin.along, pin.from,
                     std::isfinite(pin.until) ? fmt::format("until {} s", pin.until) : "on"));
  }
  for (const TimedCut& cut : scene.timeline.cuts) {
    line(fmt::format("cut: {} at {} m, at {} s", world.connectors[cut.connector].name, cut.along,
                     cut.time));
  }
  if (!scene.strange_plan.empty()) {
    line(fmt::format("plan: of another version of taut or of the scene; plan it again ({})",
                     scene.strange_plan));
  }
  if (scene.plan) {
    const scenes::Plan& plan = *scene.plan;
    line(plan.stamp != scenes::plan_stamp(scene.file)
             ? "plan: of the scene as it was; it changed since"
         : plan.program != scenes::method_stamp(plan.method)
             ? "plan: by another version of its method; plan it again"
             : fmt::format("plan: {} by {} (--planned)", scenes::certificate(plan),
                           plan.method.name));
  }
  line(fmt::format("taut simulate takes {} and {}",
                   options::space_text(options::simulation_needs(scene)), text_of(known.time)));
  if (!scene.stage) {
    line("stage: none is written; taut makes its own");
    for (const std::string& warning : warnings) line("warning: " + warning);
    return text;
  }
  const std::size_t shots = scene.stage->shots.size();
  line(fmt::format("stage{}: {}x{}; the clip has {:.0f} frames in {} shot{}",
                   known.staged ? "" : ", as none is written, taut's own", scene.width,
                   scene.height, options::clip_length(scene), shots, shots == 1 ? "" : "s"));
  const options::Needs clip =
      options::clip_needs(scene, options::clip_length(scene), kSamples, threads);
  line(fmt::format("taut render takes {}; beside simulating, drawing takes {} without a GPU",
                   options::space_text(clip), options::time_text(drawing_time(scene, clip))));
  for (const auto& [use, model] : models(scene)) {
    line(fmt::format("{}: {}, {} triangles{}", use, model->name, triangles(*model),
                     model->bones.empty() ? "" : fmt::format(", {} bones", model->bones.size())));
  }
  for (const std::string& warning : warnings) line("warning: " + warning);
  return text;
}

/// Completes the stage and looks at what its camera shows and at the choreography. Calls `tell`
/// with all that is known before each part, that this is left out among the warnings, and at the
/// end.
void look(Known known, const std::vector<scenes::SceneChange>& changes, const scenes::KnownRun& run,
          double seconds, const std::function<void(const Known&)>& tell) {
  const auto tell_without = [&](const std::string& left_out) {
    Known so_far = known;
    so_far.warnings.push_back(left_out);
    tell(so_far);
  };
  try {
    const WorkLimit limit({.cpu_time = seconds});
    scenes::Scene complete = known.scene;
    const std::string left_out = scenes::complete_stage(complete, changes, check_stop);
    known.scene = std::move(complete);
    if (!left_out.empty()) known.warnings.push_back(left_out);
  } catch (const OverLimit&) {
    return tell_without("the camera is left out: what it has to show is too much to simulate");
  }
  tell_without("what the camera shows is left out: it is too much to look at");
  for (std::string& warning : scenes::warnings_of(known.scene, run)) {
    known.warnings.push_back(std::move(warning));
  }
  tell_without("the choreography is left out: it is too much to simulate");
  if (auto missed = scenes::choreography_warning(known.scene, changes)) {
    known.warnings.push_back(std::move(*missed));
  }
  tell(known);
}

/// What a look found, as the command's output; ended after so many seconds of CPU time.
std::string looked_at(Known known, const std::vector<scenes::SceneChange>& changes,
                      const scenes::KnownRun& run, double seconds,
                      const std::function<std::string(const Known&)>& written) {
  const char* left_out = "the camera and what it shows are left out: too much to simulate";
  constexpr char kEnd = '\0', kError = '\1';  // after a text
  std::string said;
  if (options::simulation_needs(known.scene).memory <= kLookedAt) {
    said = render::run_bounded({seconds, kCopyMemory}, [&](const render::Say& say) {
             try {
               look(known, changes, run, 0.7 * seconds,
                    [&](const Known& found) { say(written(found) + kEnd); });
             } catch (const scenes::BadScene& error) {
               say(std::string(error.what()) + kError);
             }
           }).said;
  }
  // The last text that is whole.
  const std::size_t end = said.find_last_of(std::string{kEnd, kError});
  if (end == std::string::npos) {
    known.warnings.emplace_back(left_out);
    return written(known);
  }
  const std::size_t before = end == 0 ? end : said.rfind(kEnd, end - 1);
  std::string text = said.substr(before == std::string::npos ? 0 : before + 1);
  text.resize(text.find_first_of(std::string{kEnd, kError}));
  if (said[end] == kError) throw scenes::BadScene(text);
  return text;
}

int check(const std::string& file, const std::vector<std::string>& set, double started,
          const program::Common& common) {
  const double before = render::process_seconds() + render::children_seconds();
  const auto used = [&] {
    return started + render::process_seconds() + render::children_seconds() - before;
  };
  const std::vector<scenes::SceneChange> changes = options::scene_changes(set);
  Known known;
  const double read_from = render::process_seconds();
  try {
    known.scene = scenes::load_scene(file, true, changes);
  } catch (const scenes::BadScene&) {  // the first of its faults
    scenes::Faults faults = scenes::faults_of(file, changes);
    if (faults.first.empty()) throw;
    throw program::BadScenes(std::move(faults));
  }
  // Models are read by other processes; a simulation needs none.
  const double reading = started + render::process_seconds() - read_from;
  const double ready = used(), seconds = std::max(kWhole - ready, kLeast);
  known.staged = known.scene.stage.has_value();
  if (known.staged) {
    for (std::string& lacks : film::missing_glyphs(*known.scene.stage)) {
      known.warnings.push_back(std::move(lacks));
    }
  }
  Piece piece;
  known.time.unknown = why_not_tried(known.scene);
  if (known.time.unknown.empty()) {
    piece = run_piece(known.scene, kPiece * seconds);
    known.time = time_of_run(known.scene, reading, piece);
    known.cheaper = cheaper_method(known.scene, known.time, reading, piece, kCheaper * seconds);
    std::string slow = known.cheaper ? text_of(*known.cheaper, known.time, known.scene)
                                     : what_helps(known.scene, known.time);
    if (!slow.empty()) known.warnings.push_back(std::move(slow));
  }
  render::write_output(
      looked_at(known, changes, {piece.states, piece.diverged},
                std::max(ready + seconds - used(), kLook * seconds), [&](const Known& found) {
                  return common.json ? program::json_text(as_json(found, common.threads)) + '\n'
                                     : as_text(found, common.threads);
                }));
  return program::kDone;
}

int run(const Options& options, const program::Common& common) {
  if (options.schema) {
    render::write_output(scenes::scene_schema());
    return program::kDone;
  }
  if (options.features) {
    render::write_output(features_as_markdown());
    return program::kDone;
  }
  if (!options.plans.empty()) {
    render::write_output(common.json
                             ? program::json_text(planning::plans_json(options.plans)) + '\n'
                             : chart::to_markdown(planning::plan_table(options.plans)));
    return program::kDone;
  }
  if (options.inputs.scenes.empty()) {
    throw program::Misuse("check: expected a scene file, --plans, --features or --schema");
  }
  const double started = render::process_seconds();
  return options::for_each_scene(options.inputs, common, [&](const std::string& scene) {
    return check(scene, options.inputs.set, started, common);
  });
}

}  // namespace
}  // namespace check_command

void add_check(CLI::App& app, program::Program& program) {
  using namespace check_command;
  program::Command command =
      program::add_command(app, program, "check", "Validate a scene and estimate its cost",
                           R"(  taut check scenes/nunchaku.toml
  taut check scenes/nunchaku.toml --json
  taut check --plans scenes/*.toml                 their plans, as a table in Markdown
  taut check --features                            the features that each method supports
  taut check --schema > scenes/scene.schema.json   the JSON Schema, for editors)");
  const auto options = std::make_shared<Options>();
  options::add_scene_options(command, options->inputs).required(false);
  command.add_option("--plans", options->plans, "Write a table of these scenes' plans instead");
  command.add_flag("--schema", options->schema, "Write the JSON Schema of scene files instead");
  command.add_flag("--features", options->features,
                   "Write tables of the features that each method supports instead");
  command.callback([options, &program] {
    program.run = [options, &program] { return run(*options, program.common); };
  });
}

}  // namespace taut::cli
