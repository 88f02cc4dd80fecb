#include "render/study/known_answers.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <functional>
#include <limits>
#include <utility>

#include "render/base/interrupt.h"
#include "render/chart/html_page.h"
#include "render/options/method_options.h"
#include "scenes/files/files.h"
#include "scenes/load/load_scene.h"
#include "sim/evaluation/run.h"
#include "sim/links/tension.h"
#include "sim/measure/measure.h"
#include "sim/motion/stop.h"
#include "sim/run/forces.h"

namespace taut::studies {

const std::string_view kQuantitiesHelp =
    "Quantities, in SI units: NAME.3.x and NAME.3.vx (a particle's place and velocity), NAME.x,\n"
    "NAME.qw, NAME.vx and NAME.wx (a body's origin, orientation, velocity of the centre of mass "
    "and\n"
    "spin), NAME.3-4.tension (of a link), NAME.3.hold.x and NAME.3.moment.x (force on a held "
    "particle,\n"
    "moment of its clamp), NAME.contact.x (force of all contacts on a connector, a body or an "
    "obstacle),\n"
    "NAME.length, NAME.writhe, NAME.from.tension and NAME.to.tension (at a winch), NAME.passed (of "
    "a\n"
    "pulley); energy, kinetic_energy, potential_energy, elastic_energy, momentum.x,\n"
    "angular_momentum.x, stretch. Likewise y and z.";

namespace {

namespace fs = std::filesystem;

/// A simulation at the time of an answer; forces are found once, when they are asked for.
struct Now {
  const World& world;
  Snapshot state;
  std::optional<Forces> forces = {};
  bool is_asked = false;

  /// Null where no forces satisfy the laws in this state.
  const Forces* all_forces() {
    if (!is_asked) {
      is_asked = true;
      try {
        forces = forces_of(world);
      } catch (const Diverged&) {
      }
    }
    return forces ? &*forces : nullptr;
  }
};

using Quantity = std::function<double(Now&)>;

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

std::optional<Eigen::Index> axis_of(std::string_view text) {
  if (text == "x") return 0;
  if (text == "y") return 1;
  if (text == "z") return 2;
  return {};
}

std::optional<std::size_t> whole(std::string_view text) {
  std::size_t number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (text.empty() || error != std::errc() || end != text.data() + text.size()) return {};
  return number;
}

/// "3.hold.x" as "3" and "hold.x"; the second is empty where there is no dot.
std::pair<std::string_view, std::string_view> at_dot(std::string_view text) {
  const std::size_t dot = text.find('.');
  if (dot == std::string_view::npos) return {text, {}};
  return {text.substr(0, dot), text.substr(dot + 1)};
}

/// Finds the thing whose name begins `text` and is followed by a dot, and what comes after; of
/// several names the longest.
template <class List>
std::optional<std::pair<std::size_t, std::string_view>> named_in(const List& list,
                                                                 std::string_view text) {
  std::optional<std::pair<std::size_t, std::string_view>> found;
  for (std::size_t i = 0; i < list.size(); ++i) {
    const std::string_view name = list[i].name;
    if (!text.starts_with(name) || text.size() <= name.size() || text[name.size()] != '.') continue;
    if (found && list[found->first].name.size() > name.size()) continue;
    found.emplace(i, text.substr(name.size() + 1));
  }
  return found;
}

bool is_on(const Forces::Side& side, Forces::Side::Kind kind, std::size_t index) {
  using Kind = Forces::Side::Kind;
  const bool same = side.kind == kind || (kind == Kind::particle && side.kind == Kind::link);
  return same && side.index == index;
}

/// The force of all contacts on a connector (kind particle), a body or an obstacle.
Quantity contact_force(Forces::Side::Kind kind, std::size_t index, std::string_view part) {
  const auto [word, axis_text] = at_dot(part);
  const auto axis = axis_of(axis_text);
  if (word != "contact" || !axis) return {};
  return [=](Now& now) {
    if (!now.all_forces()) return kNone;
    double sum = 0;
    for (const Forces::Contact& contact : now.all_forces()->contacts) {
      if (is_on(contact.one, kind, index)) sum += contact.force[*axis];
      if (is_on(contact.other, kind, index)) sum -= contact.force[*axis];
    }
    return sum;
  };
}

Quantity hold_force(std::size_t connector, std::size_t particle, Eigen::Index axis, bool moment) {
  return [=](Now& now) {
    if (!now.all_forces()) return kNone;
    for (const Forces::Hold& hold : now.all_forces()->holds) {
      if (hold.connector != connector || hold.particle != particle) continue;
      return moment ? hold.moment[axis] : hold.force[axis];
    }
    return 0.0;  // nothing holds it
  };
}

/// Of one particle: x, vx, hold.x or moment.x.
Quantity of_particle(std::size_t connector, std::size_t particle, std::string_view part) {
  if (const auto axis = axis_of(part)) {
    return [=](Now& now) { return now.state.connectors[connector][particle][*axis]; };
  }
  if (part.starts_with('v')) {
    if (const auto axis = axis_of(part.substr(1))) {
      return [=](Now& now) { return now.world.connectors[connector].velocity[particle][*axis]; };
    }
  }
  const auto [word, axis_text] = at_dot(part);
  const auto axis = axis_of(axis_text);
  if (axis && (word == "hold" || word == "moment")) {
    return hold_force(connector, particle, *axis, word == "moment");
  }
  return {};
}

Quantity of_connector(const World& world, std::size_t c, std::string_view part) {
  const Connector& connector = world.connectors[c];
  if (part == "length") return [c](Now& now) { return now.world.connectors[c].length; };
  if (part == "writhe") return [c](Now& now) { return writhe(curve_of(now.world, c)); };
  for (const std::size_t end : {0u, 1u}) {
    if (part != (end == 0 ? "from.tension" : "to.tension")) continue;
    if (!connector.winch || !connector.winch->paths[end]) return {};
    return [=](Now& now) { return winch_tension(now.world, c, end); };
  }
  const auto [place, rest] = at_dot(part);
  if (const auto particle = whole(place); particle && *particle < connector.particles()) {
    return of_particle(c, *particle, rest);
  }
  const std::size_t dash = place.find('-');
  if (dash != std::string_view::npos && rest == "tension") {
    const auto first = whole(place.substr(0, dash)), second = whole(place.substr(dash + 1));
    if (!first || !second || *first >= connector.links() || *second != *first + 1) return {};
    return [c, link = *first](Now& now) {
      if (!now.all_forces()) return kNone;
      for (const Forces::Link& at : now.all_forces()->links) {
        if (at.connector == c && at.link == link) return at.tension;
      }
      return kNone;
    };
  }
  return contact_force(Forces::Side::Kind::particle, c, part);
}

Quantity of_body(std::size_t b, std::string_view part) {
  if (const auto axis = axis_of(part)) {
    return [=](Now& now) { return now.state.bodies[b].position[*axis]; };
  }
  if (part == "qw") return [b](Now& now) { return now.state.bodies[b].rotation.w(); };
  const auto axis = part.size() == 2 ? axis_of(part.substr(1)) : std::nullopt;
  if (!axis) return contact_force(Forces::Side::Kind::body, b, part);
  switch (part.front()) {
    case 'q':
      return [=](Now& now) { return now.state.bodies[b].rotation.vec()[*axis]; };
    case 'v':
      return [=](Now& now) { return now.world.bodies[b].velocity[*axis]; };
    case 'w':
      return [=](Now& now) { return now.world.bodies[b].spin[*axis]; };
    default:
      return {};
  }
}

Quantity of_world(std::string_view name) {
  if (name == "energy") return [](Now& now) { return energy(now.world); };
  if (name == "kinetic_energy") return [](Now& now) { return kinetic_energy(now.world); };
  if (name == "potential_energy") return [](Now& now) { return potential_energy(now.world); };
  if (name == "elastic_energy") return [](Now& now) { return elastic_energy(now.world); };
  if (name == "stretch") return [](Now& now) { return stretch_max(now.world); };
  const auto [word, axis_text] = at_dot(name);
  const auto axis = axis_of(axis_text);
  if (!axis) return {};
  if (word == "momentum") {
    return [=](Now& now) { return linear_momentum(now.world)[*axis]; };
  }
  if (word == "angular_momentum") {
    return [=](Now& now) { return angular_momentum(now.world)[*axis]; };
  }
  return {};
}

/// The things that quantities are of: those of the scene, and what its cuts leave. Pins and cuts
/// number particles anew, so that of such connectors only places are known by their names.
struct Things {
  explicit Things(const scenes::Scene& scene)
      : world(divided(scene.world, scene.timeline)),
        renumbered(!scene.timeline.pins.empty() || !scene.timeline.cuts.empty()) {}
  World world;
  bool renumbered;
};

/// The quantity of that name, or none.
Quantity quantity_of(const Things& things, std::string_view name) {
  const World& world = things.world;
  if (const auto at = named_in(world.connectors, name)) {
    const auto [particle, axis] = at_dot(at->second);
    if (!things.renumbered || axis_of(axis)) {
      if (Quantity found = of_connector(world, at->first, at->second)) return found;
    }
  }
  // An obstacle on a path has a driven body of its name, which nothing touches.
  if (const auto at = named_in(world.obstacles, name)) {
    if (Quantity found = contact_force(Forces::Side::Kind::obstacle, at->first, at->second))
      return found;
  }
  if (const auto at = named_in(world.bodies, name)) {
    if (Quantity found = of_body(at->first, at->second)) return found;
  }
  if (const auto at = named_in(world.pulleys, name); at && at->second == "passed") {
    return [p = at->first](Now& now) { return now.state.passed[p]; };
  }
  return of_world(name);
}

constexpr std::size_t kMostBytes = 16 << 20;
constexpr std::string_view kColumns = "time,quantity,value,tolerance";

/// The rows of answer.csv; lines that begin with # are comments.
std::vector<Answer> read_answers(const fs::path& file, const scenes::Scene& scene) {
  const std::string text = scenes::read_regular_file(file, kMostBytes, "rows of known answers");
  const Things things(scene);
  std::vector<Answer> answers;
  bool has_header = false;
  std::size_t number = 0;
  const auto fail = [&](const std::string& what) {
    throw scenes::BadAsset(fmt::format("{}:{}: {}", file.string(), number, what));
  };
  for (std::size_t start = 0; start < text.size();) {
    const std::size_t end = std::min(text.find('\n', start), text.size());
    std::string_view line = std::string_view(text).substr(start, end - start);
    start = end + 1;
    ++number;
    if (line.ends_with('\r')) line.remove_suffix(1);
    if (line.empty() || line.starts_with('#')) continue;
    if (!std::exchange(has_header, true)) {
      if (line != kColumns) fail(fmt::format("expected the columns {}", kColumns));
      continue;
    }
    const std::vector<std::string_view> cells = row_cells(line);
    if (cells.size() != 4) fail(fmt::format("{} cells, expected {}", cells.size(), kColumns));
    const auto time = finite_number(cells[0]), value = finite_number(cells[2]),
               tolerance = finite_number(cells[3]);
    constexpr double kRounding = 1e-9;
    if (!time || *time < 0 || *time > scene.duration * (1 + kRounding)) {
      fail(fmt::format("time: \"{}\", expected a number from 0 to the scene's duration, {} s",
                       cells[0], scene.duration));
    }
    if (!value) fail(fmt::format("value: \"{}\", expected a number", cells[2]));
    if (!tolerance || !(*tolerance > 0))
      fail(fmt::format("tolerance: \"{}\", expected a number above 0", cells[3]));
    if (!quantity_of(things, cells[1])) {
      fail(fmt::format("quantity: the scene has no \"{}\"; taut verify --help lists quantities",
                       cells[1]));
    }
    answers.push_back({*time, std::string(cells[1]), *value, *tolerance, number});
  }
  if (answers.empty()) {
    throw scenes::bad_asset(file, fmt::format("no rows, expected rows of {}", kColumns));
  }
  std::ranges::stable_sort(answers, {}, &Answer::time);
  return answers;
}

/// The lines at the top of a scene that begin with #, without it; a schema's line is left out.
std::string heading_of(const std::string& text) {
  std::string heading;
  for (std::size_t start = 0; start < text.size() && text[start] == '#';) {
    const std::size_t end = std::min(text.find('\n', start), text.size());
    std::string_view line = std::string_view(text).substr(start, end - start);
    start = end + 1;
    if (line.starts_with("#:")) continue;
    line.remove_prefix(line.starts_with("# ") ? 2 : 1);
    heading += std::string(line) + '\n';
  }
  return heading;
}

/// A quaternion and its negative are one orientation: a component has the sign that is nearer.
double signed_as(const Answer& answer, double value) {
  const std::size_t dot = answer.quantity.rfind('.');
  const bool is_quaternion = dot != std::string::npos && answer.quantity.size() == dot + 3 &&
                             answer.quantity[dot + 1] == 'q';
  const bool is_nearer = std::abs(-value - answer.value) < std::abs(value - answer.value);
  return is_quaternion && is_nearer ? -value : value;
}

bool is_case(const fs::path& folder) {
  std::error_code none;
  return fs::exists(folder / "scene.toml", none);
}

MethodChoice choice_of(const AnswerCase& of, const options::Contender& contender,
                       const std::vector<std::string>& set) {
  MethodChoice choice = contender.candidate;
  if (choice.name == of.scene.method.name) {
    for (const auto& [name, value] : of.scene.method.settings) choice.settings.emplace(name, value);
  }
  for (const auto& [name, value] : options::settings_of(*contender.method, set)) {
    if (name == "step") choice.settings.erase("tolerance");
    if (name == "tolerance") choice.settings.erase("step");
    choice.settings[name] = value;
  }
  std::string wrong = complaint(*contender.method, choice.settings);
  if (wrong.empty()) wrong = step_complaint(choice.settings, of.scene.duration);
  if (!wrong.empty()) throw program::Misuse(fmt::format("--set: {}", wrong));
  return choice;
}

}  // namespace

std::vector<fs::path> answer_folders(const std::vector<fs::path>& paths) {
  std::vector<fs::path> folders;
  for (const fs::path& path : paths) {
    if (is_case(path)) {
      folders.push_back(path);
      continue;
    }
    std::vector<fs::path> inside;
    std::error_code error;
    for (fs::directory_iterator entry(path, error), last; !error && entry != last;
         entry.increment(error)) {
      if (is_case(entry->path())) inside.push_back(entry->path());
    }
    if (inside.empty()) {
      throw scenes::bad_asset(
          path, "no known answers, expected a folder with scene.toml and answer.csv, or of such");
    }
    std::ranges::sort(inside);
    folders.insert(folders.end(), inside.begin(), inside.end());
  }
  return folders;
}

AnswerCase read_answer_case(const fs::path& folder) {
  AnswerCase made;
  made.folder = folder;
  const fs::path plain = folder.lexically_normal();
  made.name = (plain.has_filename() ? plain : plain.parent_path()).filename().string();
  made.scene = scenes::load_scene(folder / "scene.toml", false);
  made.heading = heading_of(scenes::read_bytes(folder / "scene.toml"));
  made.answers = read_answers(folder / "answer.csv", made.scene);
  return made;
}

std::optional<double> finite_number(std::string_view text) {
  double number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(number)) return {};
  return number;
}

std::vector<std::string_view> row_cells(std::string_view line) {
  std::vector<std::string_view> cells;
  for (;;) {
    const std::size_t comma = line.find(',');
    cells.push_back(line.substr(0, comma));
    if (comma == std::string_view::npos) return cells;
    line.remove_prefix(comma + 1);
  }
}

std::string text_of(Verdict::Kind kind) {
  switch (kind) {
    case Verdict::Kind::passes:
      return "passes";
    case Verdict::Kind::fails:
      return "fails";
    case Verdict::Kind::diverged:
      return "diverged";
    case Verdict::Kind::over_cap:
      return "over the cap";
    case Verdict::Kind::broken:
      return "broken";
    case Verdict::Kind::not_followed:
      return "not run";
  }
  return "";
}

void judge(Verdict& verdict, const AnswerCase& of, double value) {
  const Answer& answer = of.answers[verdict.values.size()];
  value = signed_as(answer, value);
  const double share = std::isfinite(value) ? std::abs(value - answer.value) / answer.tolerance
                                            : std::numeric_limits<double>::infinity();
  if (share > verdict.share) {
    verdict.share = share;
    verdict.worst = verdict.values.size();
  }
  verdict.values.push_back(value);
  if (!(verdict.share <= 1)) verdict.kind = Verdict::Kind::fails;
}

Verdict verify(const AnswerCase& of, const options::Contender& contender,
               const std::vector<std::string>& set, double cpu_cap) {
  Verdict verdict;
  verdict.reason = contender.method->missing;
  if (verdict.reason.empty()) verdict.reason = refusal(*contender.method, of.scene.world);
  if (!verdict.reason.empty()) {
    verdict.kind = Verdict::Kind::not_followed;
    return verdict;
  }
  const MethodChoice choice = choice_of(of, contender, set);
  Simulation simulation = scenes::start(of.scene, choice);
  const World& world = std::as_const(simulation).world();
  const Things things(of.scene);
  std::vector<Quantity> quantities;
  for (const Answer& answer : of.answers)
    quantities.push_back(quantity_of(things, answer.quantity));
  const double begun = thread_seconds();
  const WorkLimit limit({.cpu_time = cpu_cap});
  const auto ended = [&](Verdict::Kind kind, const char* why) {
    verdict.kind = kind;
    verdict.reason = why;
  };
  verdict.states.push_back(simulation.state());
  try {
    for (std::size_t i = 0; i < of.answers.size();) {
      render::stop_if_interrupted();
      const double time = of.answers[i].time, before = thread_seconds();
      simulation.advance_to(time);
      verdict.cpu += thread_seconds() - before;
      Now now{world, simulation.state()};
      verdict.states.push_back(now.state);
      for (; i < of.answers.size() && of.answers[i].time == time; ++i) {
        judge(verdict, of, quantities[i](now));
      }
    }
  } catch (const OverLimit&) {
    if (!limit.reached()) throw;
    verdict.cpu = std::max(verdict.cpu, thread_seconds() - begun);
    ended(Verdict::Kind::over_cap, "more CPU time than --cap");
  } catch (const Diverged& error) {
    ended(Verdict::Kind::diverged, error.what());
  } catch (const BadIntervention& error) {
    ended(Verdict::Kind::diverged, error.what());
  }
  return verdict;
}

namespace {

/// States as a drawing of lines, seen along z, or along x where that shows more: the last one dark,
/// those before faint.
std::string drawing(const std::vector<Snapshot>& states) {
  constexpr double kWidth = 260, kHeight = 200, kMargin = 14;  // px
  constexpr std::size_t kMost = 24;                            // states
  Eigen::AlignedBox3d box;
  for (const Snapshot& state : states) {
    for (const auto& particles : state.connectors)
      for (const Vec3& at : particles) box.extend(at);
    for (const Pose& body : state.bodies) box.extend(body.position);
  }
  if (box.isEmpty()) return {};
  const bool along_x = box.sizes().z() > box.sizes().x();
  const double wide = along_x ? box.sizes().z() : box.sizes().x();
  const double scale = std::min((kWidth - 2 * kMargin) / std::max(wide, 1e-9),
                                (kHeight - 2 * kMargin) / std::max(box.sizes().y(), 1e-9));
  const Vec3 centre = box.center();
  const auto place = [&](const Vec3& at) {
    const double x = along_x ? centre.z() - at.z() : at.x() - centre.x();
    return fmt::format("{:.1f},{:.1f}", kWidth / 2 + scale * x,
                       kHeight / 2 - scale * (at.y() - centre.y()));
  };
  std::string lines;
  const std::size_t stride = (states.size() + kMost - 1) / kMost;
  for (std::size_t i = 0; i < states.size(); ++i) {
    const bool is_last = i + 1 == states.size();
    if (!is_last && i % stride != 0) continue;
    lines += fmt::format("<g opacity=\"{}\">", is_last ? "1" : "0.3");
    for (std::size_t c = 0; c < states[i].connectors.size(); ++c) {
      lines += "<polyline points=\"";
      for (const Vec3& at : states[i].connectors[c]) lines += place(at) + ' ';
      lines += "\"/>";
      for (const Vec3* at : {&states[i].connectors[c].front(), &states[i].connectors[c].back()}) {
        const std::string xy = place(*at);
        const auto comma = xy.find(',');
        lines += fmt::format("<circle cx=\"{}\" cy=\"{}\" r=\"2\"/>", xy.substr(0, comma),
                             xy.substr(comma + 1));
      }
    }
    for (const Pose& body : states[i].bodies) {
      const std::string xy = place(body.position);
      const auto comma = xy.find(',');
      lines += fmt::format("<circle cx=\"{}\" cy=\"{}\" r=\"4\"/>", xy.substr(0, comma),
                           xy.substr(comma + 1));
    }
    lines += "</g>";
  }
  return fmt::format(
      "<svg viewBox=\"0 0 {0} {1}\" width=\"{0}\" height=\"{1}\" fill=\"none\" "
      "stroke=\"currentColor\" stroke-width=\"1.5\" role=\"img\" "
      "aria-label=\"states of the scene\">{2}</svg>\n",
      kWidth, kHeight, lines);
}

chart::Table table_of(const Verified& one) {
  chart::Table table{{"t (s)", "quantity", "answer", "tolerance"}, {}};
  for (const auto& [method, verdict] : one.verdicts) {
    if (!verdict.values.empty()) table.columns.push_back("error of " + method);
  }
  for (std::size_t i = 0; i < one.of.answers.size(); ++i) {
    const Answer& answer = one.of.answers[i];
    std::vector<std::string> row{fmt::format("{:.6g}", answer.time), answer.quantity,
                                 fmt::format("{:.9g}", answer.value),
                                 fmt::format("{:.2g}", answer.tolerance)};
    for (const auto& [method, verdict] : one.verdicts) {
      if (verdict.values.empty()) continue;
      row.push_back(i < verdict.values.size()
                        ? fmt::format("{:.2g}", verdict.values[i] - answer.value)
                        : "-");
    }
    table.add(std::move(row));
  }
  return table;
}

}  // namespace

std::string answers_page(const std::vector<Verified>& all) {
  std::string body;
  for (const Verified& one : all) {
    body += fmt::format("<h2 id=\"{0}\">{0}: {1}</h2>\n<p>", chart::escape_html(one.of.name),
                        chart::escape_html(one.of.scene.title));
    for (const auto& [method, verdict] : one.verdicts) {
      body += fmt::format("<b>{}</b>: {}", chart::escape_html(method), text_of(verdict.kind));
      if (!verdict.values.empty()) {
        body += fmt::format(", at most {:.2g} of the tolerance, {:.3g} ms", verdict.share,
                            1e3 * verdict.cpu);
      }
      if (!verdict.reason.empty()) body += ": " + chart::escape_html(verdict.reason);
      body += "<br>\n";
    }
    body += "</p>\n";
    const auto ran = std::ranges::find_if(
        one.verdicts, [](const auto& entry) { return !entry.second.states.empty(); });
    if (ran != one.verdicts.end()) body += drawing(ran->second.states);
    body += fmt::format("<pre>{}</pre>\n{}", chart::escape_html(one.of.heading),
                        chart::to_html(table_of(one)));
  }
  return chart::html_page("Known answers", body);
}

}  // namespace taut::studies
