#include "render/film/comparison.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>

#include "render/picture/text.h"
#include "sim/world/held.h"

namespace taut::film {
namespace {

constexpr float kGhost = 0.35f;    // opacity
constexpr float kOverlay = 0.85f;  // opacity of methods over each other
constexpr double kUnit = 0.0215;   // of the picture's height, that of the type
constexpr double kSmallest = 10;   // px, of the type
constexpr double kCharts = 0.52;   // of the picture's width; the rest is the costs'
constexpr double kPanel = 0.42;    // of its width, where methods lie over each other
constexpr int kMostColumns = 6;
constexpr std::size_t kMostTethers = 4;  // whose reach is drawn
constexpr double kFramed = 1.5;  // times the reach, up to which what moves is kept in the panel

/// Nothing casts a shadow: its map is as small as can be.
constexpr draw::Shading kShading{.map_size = 64};

/// sRGB to linear light (IEC 61966-2-1).
Vec3 linear(picture::Rgb color) {
  Vec3 light;
  for (std::size_t k = 0; k < 3; ++k) {
    const double x = color[k] / 255.0;
    light[Eigen::Index(k)] = x <= 0.04045 ? x / 12.92 : std::pow((x + 0.055) / 1.055, 2.4);
  }
  return light;
}

/// The stage with what moves in one colour, but for people.
scenes::Stage coloured(const scenes::Stage& stage, const Vec3& color, std::size_t connectors) {
  scenes::Stage result = stage;
  result.characters.clear();
  result.connector_looks.resize(std::max(connectors, result.connector_looks.size()));
  for (scenes::ConnectorLook& look : result.connector_looks) look.color = look.weight_color = color;
  for (auto& model : result.body_models) {
    if (!model) continue;
    scenes::Model painted = *model;
    for (scenes::Material& material : painted.materials)
      for (std::size_t k = 0; k < 3; ++k) material.base_color[k] = float(color[Eigen::Index(k)]);
    model = std::make_shared<const scenes::Model>(std::move(painted));
  }
  return result;
}

/// Cells in rows of so many, from the upper left.
std::vector<picture::Rect> cells(std::size_t count, int columns, const picture::Rect& area) {
  const int rows = (int(count) + columns - 1) / columns;
  std::vector<picture::Rect> result;
  for (int i = 0; i < int(count); ++i) {
    const int x = area.width * (i % columns) / columns, y = area.height * (i / columns) / rows;
    result.push_back({area.x + x, area.y + y, area.width * (i % columns + 1) / columns - x,
                      area.height * (i / columns + 1) / rows - y});
  }
  return result;
}

/// The corners of the boxes round the models of bodies, in their own frames.
std::vector<std::vector<Vec3>> corners(const scenes::Stage& stage) {
  std::vector<std::vector<Vec3>> result;
  for (const auto& model : stage.body_models) {
    Eigen::AlignedBox3d box;
    if (model)
      for (const scenes::Mesh& mesh : model->meshes)
        for (const auto& vertex : mesh.vertices)
          box.extend(Vec3(vertex.position[0], vertex.position[1], vertex.position[2]));
    std::vector<Vec3>& points = result.emplace_back();
    if (box.isEmpty()) points.push_back(Vec3::Zero());
    for (int k = 0; k < 8 && !box.isEmpty(); ++k)
      points.push_back(box.corner(Eigen::AlignedBox3d::CornerType(k)));
  }
  return result;
}

/// A circle round `centre` in the plane that faces the camera.
std::vector<Vec3> circle(const Vec3& centre, double radius, const scenes::CameraView& camera) {
  constexpr int kSides = 120;
  const Vec3 forward = (centre - camera.position).normalized();
  const Vec3 right = forward.cross(Vec3::UnitY()).normalized(), up = right.cross(forward);
  std::vector<Vec3> points;
  for (int i = 0; i <= kSides; ++i) {
    const double angle = 2 * std::numbers::pi * i / kSides;
    points.push_back(centre + radius * (std::sin(angle) * right + std::cos(angle) * up));
  }
  return points;
}

/// Where points are seen, px from the upper left corner of the picture; not numbers behind it.
std::array<double, 2> seen(const Vec3& point, const scenes::CameraView& camera,
                           const picture::Rect& view) {
  const Vec3 forward = (camera.target - camera.position).normalized();
  const Vec3 right = forward.cross(Vec3::UnitY()).normalized(), up = right.cross(forward);
  const Vec3 from = point - camera.position;
  const double depth = from.dot(forward);
  if (depth < 1e-6) return {NAN, NAN};
  const double scale = view.height / (2 * std::tan(camera.field_of_view / 2) * depth);
  return {view.x + view.width / 2.0 + scale * from.dot(right),
          view.y + view.height / 2.0 - scale * from.dot(up)};
}

}  // namespace

ComparisonFilm::ComparisonFilm(const gl::Context& context, const scenes::Scene& scene,
                               const Comparison& comparison, int width, int height, int samples,
                               Layout layout)
    : scene_(scene),
      comparison_(comparison),
      layout_(layout),
      width_(width),
      height_(height),
      unit_(std::max(kUnit * height, kSmallest)),
      areas_(areas(width, height, unit_, comparison.methods.size(), layout)),
      passes_(samples, context.max_samples()),
      canvas_(context, areas_.panels.width, areas_.panels.height, passes_.each),
      renderer_(context, *scene.stage, divided(scene.world, scene.timeline), kShading),
      faint_(width, height) {
  if (layout_ == Layout::over) {
    for (const ComparedMethod& method : comparison_.methods)
      coloured_.push_back(
          coloured(*scene.stage, linear(rgb(method.style.color)), scene.world.connectors.size()));
    for (const scenes::Stage& stage : coloured_)
      overlays_.push_back(std::make_unique<draw::StageRenderer>(
          context, stage, divided(scene.world, scene.timeline), kShading));
  }
  lay_out();
  draw_costs();
  full_ = faint_;
  draw_charts();
}

ComparisonFilm::Areas ComparisonFilm::areas(int width, int height, double unit, std::size_t methods,
                                            Layout layout) {
  const int header = std::clamp(int(2.2 * unit), 1, std::max(height / 4, 1));
  const int costs =
      std::clamp(int((double(methods) + 2.6) * 1.4 * unit), height * 31 / 100, height * 42 / 100);
  const auto at_least = [](picture::Rect rect) {
    rect.width = std::max(rect.width, 1);
    rect.height = std::max(rect.height, 1);
    return rect;
  };
  if (layout == Layout::over) {
    const int left = std::max(int(kPanel * width), 1);
    const int list = std::clamp(int((double(methods) + 1.5) * 1.6 * unit), 0, height / 3);
    return {{0, 0, width, header},
            at_least({0, header, left, height - header}),
            {left, header, width - left, list},
            {left, header + list, width - left, std::max(height - header - list - costs, 0)},
            {left, height - costs, width - left, costs}};
  }
  const int middle = int(kCharts * width);
  return {{0, 0, width, header},
          at_least({0, header, width, height - header - costs}),
          {},
          {0, height - costs, middle, costs},
          {middle, height - costs, width - middle, costs}};
}

double ComparisonFilm::verdict_size(const picture::Rect& cell) const {
  return cell.width < 12 * unit_ ? 0.9 * unit_ : unit_;
}

std::vector<ComparisonFilm::Panel> ComparisonFilm::panels(int columns) {
  if (layout_ == Layout::over) return {{areas_.panels, areas_.panels}};
  std::vector<Panel> result;
  int above = 0, below = 0;
  const auto found = cells(comparison_.methods.size(), columns, areas_.panels);
  const double width = found.front().width - unit_;
  for (const ComparedMethod& method : comparison_.methods) {
    const double rows = double(name_lines(method, width).size()) * 1.25 +
                        double(numbers(method, 0).size() > 1 && width < 16 * unit_ ? 2 : 1) * 1.2;
    above = std::max(above, int((rows + 0.9) * unit_));
    const double size = verdict_size(found.front());
    const auto lines = picture::wrapped(bold_, method.verdict.text, size, width);
    below = std::max(below, int((double(lines.size()) * 1.25 + 0.6) * size));
  }
  for (const picture::Rect& cell : found) {
    const int top = std::min(above, cell.height / 3), bottom = std::min(below, cell.height / 3);
    result.push_back({cell, {cell.x, cell.y + top, cell.width, cell.height - top - bottom}});
  }
  return result;
}

/// Everything that moves, and the circles of reach. What goes far beyond the only reach is left
/// out.
std::vector<Vec3> ComparisonFilm::framed_points() const {
  std::vector<Vec3> points;
  const scenes::CameraView camera = scenes::camera_at(scene_.stage->camera, 0);
  const auto models = corners(*scene_.stage);
  const auto add = [&](const Snapshot& state, bool reaches) {
    double most = INFINITY;
    Vec3 centre = Vec3::Zero();
    for (const Tether& tether : tethers_) {
      const auto& particles = state.connectors[tether.connector];
      centre = tether.last ? particles.back() : particles.front();
      if (tethers_.size() == 1 && state.bodies.empty()) most = kFramed * tether.length;
      if (!reaches) continue;
      const auto round = circle(centre, tether.length, camera);
      points.insert(points.end(), round.begin(), round.end());
    }
    const auto add_point = [&](const Vec3& point) {
      if (point.allFinite() && (point - centre).norm() <= most) points.push_back(point);
    };
    for (const auto& particles : state.connectors)
      for (const Vec3& particle : particles) add_point(particle);
    for (std::size_t b = 0; b < state.bodies.size(); ++b)
      if (b < models.size())
        for (const Vec3& corner : models[b])
          add_point(state.bodies[b].position + state.bodies[b].rotation * corner);
  };
  // As the truth has it; behind its end, as the first of the best methods has it.
  std::size_t known = 0;
  while (known < comparison_.truth.size() &&
         (known == 0 || comparison_.truth[known].time <= comparison_.horizon))
    add(comparison_.truth[known++], true);
  const ComparedMethod& shown =
      *std::ranges::min_element(comparison_.methods, {}, [](const ComparedMethod& method) {
        return method.verdict.grade;  // in their order, the right ones first
      });
  const bool all =
      layout_ == Layout::over || (tethers_.size() == 1 && comparison_.truth.front().bodies.empty());
  for (const ComparedMethod& method : comparison_.methods)
    if (all || &method == &shown)
      for (std::size_t k = all ? 0 : known; k < method.states.size(); ++k)
        add(method.states[k], &method == &shown && k % std::size_t(comparison_.slower) == 0);
  return points;
}

void ComparisonFilm::lay_out() {
  if (scene_.timeline.empty()) {
    for (std::size_t c = 0; c < scene_.world.connectors.size(); ++c) {
      const Connector& connector = scene_.world.connectors[c];
      if (connector.winch) continue;
      bool first = false, last = false;
      for (const Hold& hold : connector.holds) {
        if (!is_prescribed(scene_.world, hold.to)) continue;
        first |= hold.particle == 0;
        last |= hold.particle + 1 == connector.particles();
      }
      if (first != last) tethers_.push_back({c, last, connector.length});
    }
    if (tethers_.size() > kMostTethers) tethers_.clear();
  }
  const std::size_t count = layout_ == Layout::over ? 1 : comparison_.methods.size();
  panels_ = panels(count == 4 ? 2 : std::min(int(count), 3));
  // People, and cameras that move, are seen as the scene has them.
  if (!scene_.stage->characters.empty() || scene_.stage->camera.size() != 1) return;
  const scenes::CameraView camera = scenes::camera_at(scene_.stage->camera, 0);
  const std::vector<Vec3> points = framed_points();
  double best = 0;  // px to a metre
  for (int columns = 1; columns <= std::min(int(count), kMostColumns); ++columns) {
    std::vector<Panel> tried = panels(columns);
    const picture::Rect& view = tried.front().view;
    if (view.width < 1 || view.height < 1) continue;
    const scenes::CameraView sees = framed(camera, points, double(view.width) / view.height, 0);
    const double scale = pixels_per_metre(sees, view.height);
    if (scale <= best) continue;
    best = scale;
    camera_ = sees;
    panels_ = std::move(tried);
  }
}

scenes::CameraView ComparisonFilm::camera(double time) const {
  return camera_ ? *camera_ : scenes::camera_at(scene_.stage->camera, time);
}

/// A length in the first panel, as long as it is where the camera looks.
void ComparisonFilm::draw_scale(picture::Picture& picture) {
  const picture::Rect& view = panels_.front().view;
  if (!camera_ || view.empty()) return;
  const double metre = pixels_per_metre(*camera_, view.height);
  const double length = round_length(0.35 * view.width / metre), size = 0.85 * unit_;
  const int wide = std::max(int(std::lround(length * metre)), 1),
            thick = std::max(height_ / 360, 1);
  const int left = view.x + int(0.6 * size), bottom = view.top() - int(0.6 * size);
  picture::fill(picture, {left, bottom - thick, wide, thick}, kInk);
  for (const int x : {left, left + wide - thick})
    picture::fill(picture, {x, bottom - 3 * thick, thick, 3 * thick}, kInk);
  const std::string text = length >= 1      ? fmt::format("{:g} m", length)
                           : length >= 0.01 ? fmt::format("{:g} cm", 1e2 * length)
                                            : fmt::format("{:g} mm", 1e3 * length);
  font_.draw(picture, text, left, bottom - 4 * thick - 0.2 * size, size, kInk);
}

draw::FrameState ComparisonFilm::instant(const Snapshot& state, double time) const {
  draw::FrameState instant{state, {}, camera(time)};
  for (const auto& performance : scene_.performances)
    instant.bones.push_back(performance->bones_at(time));
  return instant;
}

const Snapshot& ComparisonFilm::state_of(const ComparedMethod& method, std::size_t instant) const {
  const std::size_t last = std::min(instant + 1, method.states.size());
  return last ? method.states[last - 1] : comparison_.truth.front();
}

bool ComparisonFilm::is_stopped(const ComparedMethod& method, std::size_t instant) const {
  return !method.failure.empty() && instant >= method.states.size();
}

void ComparisonFilm::draw_beside(std::span<const draw::View> views, std::size_t at) {
  const double time = comparison_.time_of(at);
  for (std::size_t i = 0; i < views.size(); ++i) {
    if (views[i].viewport.empty()) continue;
    const Snapshot& state = state_of(comparison_.methods[i], at);
    renderer_.draw(canvas_, views[i].viewport, instant(state, time), {.shadow = false});
    if (time <= comparison_.horizon && at > 0 && at < comparison_.truth.size())
      renderer_.draw(canvas_, views[i].viewport, instant(comparison_.truth[at], time),
                     {.characters = false, .opacity = kGhost});
  }
}

void ComparisonFilm::draw_over(const draw::View& view, std::size_t at) {
  const double time = comparison_.time_of(at);
  const bool known = time <= comparison_.horizon && at > 0 && at < comparison_.truth.size();
  const Snapshot& shown = known ? comparison_.truth[at] : state_of(comparison_.methods.front(), at);
  renderer_.draw(canvas_, view.viewport, instant(shown, time),
                 {.bodies = false, .connectors = false, .shadow = false});
  for (std::size_t i = 0; i < overlays_.size(); ++i)
    overlays_[i]->draw(canvas_, view.viewport, instant(state_of(comparison_.methods[i], at), time),
                       {.characters = false, .opacity = kOverlay});
  if (known)
    renderer_.draw(canvas_, view.viewport, instant(comparison_.truth[at], time),
                   {.characters = false, .opacity = kGhost});
}

void ComparisonFilm::draw_reach(picture::Picture& picture, const Panel& panel,
                                const Snapshot& state, double time) {
  const scenes::CameraView view = camera(time);
  for (const Tether& tether : tethers_) {
    const auto& particles = state.connectors[tether.connector];
    const Vec3& centre = tether.last ? particles.back() : particles.front();
    std::vector<std::array<double, 2>> line;
    for (const Vec3& point : circle(centre, tether.length, view)) {
      auto p = seen(point, view, panel.view);
      if (p[0] < panel.view.x || p[0] > panel.view.right() || p[1] < panel.view.y ||
          p[1] > panel.view.top())
        p = {NAN, NAN};
      line.push_back(p);
    }
    picture::stroke(picture, line, std::max(0.08 * unit_, 1.0), {40, 70, 130}, 0.75);
    if (tethers_.size() > 1 || !std::isfinite(line.front()[0])) continue;
    const double size = 0.8 * unit_, wide = font_.width("reach", size);
    font_.draw(picture, "reach", line.front()[0] - wide / 2, line.front()[1] - 0.35 * size, size,
               {40, 70, 130});
  }
}

/// The panels' pictures alone, in their places; the same instant is drawn once.
picture::Picture ComparisonFilm::draw_scene(std::size_t at) {
  if (drawn_ == at) return drawn_picture_;
  const double time = comparison_.time_of(at);
  std::vector<draw::View> views;
  for (const Panel& panel : panels_)
    views.push_back({{panel.view.x - areas_.panels.x, areas_.panels.top() - panel.view.top(),
                      panel.view.width, panel.view.height},
                     camera(time)});
  std::vector<draw::View> visible;
  for (const draw::View& view : views)
    if (!view.viewport.empty()) visible.push_back(view);
  std::vector<picture::Picture> pictures;
  for (int i = 0; i < passes_.count; ++i) {
    renderer_.set_shift(passes_.shift(i));
    for (const auto& overlay : overlays_) overlay->set_shift(passes_.shift(i));
    renderer_.begin(canvas_, visible);
    if (layout_ == Layout::over) {
      if (!visible.empty()) draw_over(visible.front(), at);
    } else {
      draw_beside(views, at);
    }
    pictures.push_back(canvas_.finish());
  }
  drawn_picture_ = mean(pictures);
  drawn_ = at;
  return drawn_picture_;
}

picture::Picture ComparisonFilm::draw(const Moment& moment) {
  if (last_ == moment) return last_picture_;  // stops and the card stand still
  const std::size_t at = moment.instant;
  picture::Picture picture = faint_;
  picture::paste(draw_scene(at), picture, areas_.panels.x, areas_.panels.y);
  // Places of the grid that no panel has.
  const picture::Rect& end = panels_.back().cell;
  picture::fill(picture, {end.right(), end.y, areas_.panels.right() - end.right(), end.height},
                kPaper);
  for (std::size_t i = 0; i < panels_.size(); ++i)
    draw_reach(picture, panels_[i], state_of(comparison_.methods[i], at), comparison_.time_of(at));
  if (layout_ == Layout::over)
    draw_list(picture, at);
  else
    for (std::size_t i = 0; i < panels_.size(); ++i) draw_panel(picture, i, at);
  draw_scale(picture);
  draw_cursor(picture, at);
  draw_header(picture, moment);
  if (!moment.stopped.empty()) draw_stop(picture, moment);
  if (moment.card > 0) draw_card(picture, moment.card);
  last_ = moment;
  last_picture_ = picture;
  return picture;
}

// A comparison's charts and costs, and the line that runs along the charts.

namespace {

constexpr double kMost = 1e3;  // a share; what is beyond is drawn there
constexpr picture::Rgb kLine = {222, 224, 228}, kBand = {214, 238, 220};

/// Values over decades and around zero: linear up to `least`, logarithmic beyond.
double scaled(double value, double least) {
  return std::copysign(std::log10(1 + std::abs(value) / least), value);
}

/// A power of ten with its unit.
std::string decade(double seconds) {
  if (seconds < 0.9e-3) return fmt::format("{:.0f} µs", 1e6 * seconds);
  return seconds < 0.9 ? fmt::format("{:.0f} ms", 1e3 * seconds) : fmt::format("{:.0f} s", seconds);
}

/// A number with two digits, without exponent.
std::string two_digits(double value) {
  if (value < 0.01) return fmt::format("{:.1g}", value);
  if (value < 9.95) return fmt::format("{:.2g}", value);
  const double unit = std::pow(10, std::floor(std::log10(value)) - 1);
  const std::string digits = fmt::format("{:.0f}", std::round(value / unit) * unit);
  std::string text;
  for (std::size_t i = 0; i < digits.size(); ++i) {
    if (i > 0 && (digits.size() - i) % 3 == 0) text += ',';
    text += digits[i];
  }
  return text;
}

/// A time in its unit, with two digits.
std::string duration(double seconds) {
  if (seconds < 0.95e-3) return two_digits(1e6 * seconds) + " µs";
  return seconds < 0.95 ? two_digits(1e3 * seconds) + " ms" : two_digits(seconds) + " s";
}

}  // namespace

void ComparisonFilm::draw_charts() {
  const picture::Rect& area = areas_.charts;
  std::vector<Measure> measures;
  if (comparison_.by_truth)
    measures.push_back(Measure::distance);
  else if (std::ranges::any_of(comparison_.methods,
                               [](const ComparedMethod& method) { return !method.energy.empty(); }))
    measures.push_back(Measure::energy);
  measures.push_back(Measure::stretch);
  const int wide = area.width / int(measures.size());
  for (int i = 0; const Measure measure : measures)
    draw_chart(measure, {area.x + i++ * wide, area.y, wide, area.height});
}

void ComparisonFilm::draw_chart(Measure measure, const picture::Rect& area) {
  const double size = 0.85 * unit_;
  Plot plot{.area = {area.x + int((measure == Measure::distance ? 5 : 4.2) * size),
                     area.y + int(1.9 * unit_),
                     area.width - int((measure == Measure::distance ? 6 : 5.2) * size),
                     area.height - int(3.6 * unit_)}};
  if (plot.area.width < 8 || plot.area.height < 8) return;
  const bool signs = measure == Measure::energy;
  const double kept = measure == Measure::distance ? kKept * comparison_.length : kKept;
  const double least = kept / (measure == Measure::distance ? 100 : 10);
  const auto values_of = [&](const ComparedMethod& method) -> const std::vector<double>& {
    return measure == Measure::distance ? method.distance
           : measure == Measure::energy ? method.energy
                                        : method.stretch;
  };
  plot.high = scaled(2 * kept, least);
  plot.low = signs ? -plot.high : 0;
  for (const ComparedMethod& method : comparison_.methods)
    for (const double value : values_of(method)) {
      const double y = scaled(std::clamp(value, -kMost, kMost), least);
      plot.low = std::min(plot.low, signs ? 1.05 * y : 0.0);
      plot.high = std::max(plot.high, 1.05 * y);
    }
  const double end = std::max(comparison_.times.back(), 1e-9);
  const auto height_of = [&](double value) {
    const double share = (scaled(value, least) - plot.low) / (plot.high - plot.low);
    return plot.area.top() - std::clamp(share, 0.0, 1.0) * plot.area.height;
  };
  const auto place_of = [&](double time) { return plot.area.x + time / end * plot.area.width; };

  const std::string title = measure == Measure::distance ? "Mean distance from the truth"
                            : signs                      ? "Energy gained or lost"
                                                         : "Stretch of the worst link";
  const double left = area.x + 0.6 * size;
  const double fits = std::min(1.0, (area.width - 1.6 * size) / bold_.width(title, unit_));
  for (picture::Picture* picture : {&faint_, &full_}) {
    const int top = int(std::lround(height_of(kept))),
              bottom = signs && comparison_.loses ? plot.area.top()
                                                  : int(std::lround(height_of(signs ? -kept : 0)));
    picture::fill(*picture, {plot.area.x, top, plot.area.width, bottom - top}, kBand);
    bold_.draw(*picture, title, left, area.y + 1.3 * unit_, fits * unit_, kInk);
    const double scale = left + bold_.width(title, unit_) + 0.6 * unit_;
    if (signs && scale + font_.width(comparison_.energy_scale, size) < area.right() - 0.3 * unit_)
      font_.draw(*picture, comparison_.energy_scale, scale, area.y + 1.3 * unit_, size, kGrey);
    // Decades from that of what is kept on, outwards; zero.
    std::vector<double> tics{0};
    const double unit =
        measure == Measure::distance ? std::pow(10, std::ceil(std::log10(least))) : kept;
    for (double tic = unit; tic <= kMost; tic *= 10) {
      tics.push_back(tic);
      if (signs) tics.push_back(-tic);
    }
    std::vector<double> taken;
    for (const double tic : tics) {
      const double at = scaled(tic, least);
      if (at < plot.low || at > plot.high) continue;
      const double y = height_of(tic);
      if (std::ranges::any_of(taken,
                              [&](double other) { return std::abs(y - other) < 1.1 * size; }))
        continue;
      taken.push_back(y);
      picture::fill(*picture, {plot.area.x, int(y), plot.area.width, 1}, kLine);
      const std::string text = measure == Measure::distance ? fmt::format("{:g} mm", 1e3 * tic)
                                                            : fmt::format("{}{:g}%",
                                                                          tic < 0            ? "−"
                                                                          : signs && tic > 0 ? "+"
                                                                                             : "",
                                                                          100 * std::abs(tic));
      font_.draw(*picture, text, plot.area.x - 0.4 * size - font_.width(text, 0.9 * size),
                 y + 0.33 * size, 0.9 * size, kGrey);
    }
    const double step = [&] {
      const double power = std::pow(10, std::floor(std::log10(end)));
      for (const double part : {0.1, 0.2, 0.5, 1.0, 2.0, 5.0})
        if (place_of(part * power) - place_of(0) > 3.2 * size) return part * power;
      return 10 * power;
    }();
    for (int k = 0; k * step <= end * (1 + 1e-9); ++k) {
      const std::string text = fmt::format("{:g}{}", k * step, k == 0 ? " s" : "");
      font_.draw(*picture, text, place_of(k * step) - font_.width(text, 0.9 * size) / 2,
                 plot.area.top() + 1.2 * size, 0.9 * size, kGrey);
      picture::fill(*picture, {int(place_of(k * step)), plot.area.top() - 3, 1, 3}, kGrey);
    }
    if (comparison_.by_truth && comparison_.horizon < end)
      picture::fill(*picture,
                    {int(place_of(comparison_.horizon)), plot.area.y, 1, plot.area.height}, kGrey);
    for (const ComparedMethod& method : comparison_.methods) {
      std::vector<std::array<double, 2>> line;
      const std::vector<double>& values = values_of(method);
      for (std::size_t k = 0; k < values.size(); ++k)
        line.push_back(
            {place_of(comparison_.times[k]), height_of(std::clamp(values[k], -kMost, kMost))});
      picture::stroke(*picture, line, std::max(0.13 * unit_, 1.2), rgb(method.style.color),
                      picture == &full_ ? 1 : 0.22);
    }
    picture::fill(*picture, {plot.area.x, plot.area.y, 1, plot.area.height}, kGrey);
  }
  plots_.push_back(plot);
}

/// CPU time as bars on a logarithmic scale, and how fast that is beside real time.
void ComparisonFilm::draw_costs() {
  const picture::Rect& area = areas_.costs;
  const double left = area.x + unit_, right = area.right() - unit_;
  bold_.draw(faint_, "CPU time for 1 s of motion", left, area.y + 1.3 * unit_, unit_, kInk);
  const double size = unit_, small = 0.85 * unit_;
  double names = 0, least = INFINITY, most = 0;
  std::vector<double> costs;  // s to a second of motion
  for (const ComparedMethod& method : comparison_.methods) {
    const double seconds = 1e-6 * method.cpu_us * comparison_.fps;
    if (seconds > 0) {
      least = std::min(least, seconds);
      most = std::max(most, seconds);
    }
    costs.push_back(seconds);
    names = std::max(names, bold_.width(method.label, size));
  }
  if (!(most > 0)) least = most = 1e-3;
  const double low = std::floor(std::log10(least) - 0.3), high = std::log10(most);
  const double start = left + names + unit_;
  std::vector<std::string> texts;
  double wide = 0;
  for (const bool brief : {false, true}) {  // the bars keep a third of the room
    if (brief && wide > (right - start) / 3) break;
    texts.clear();
    wide = right - start - 0.6 * unit_;
    for (const double seconds : costs) {
      std::string text = "not run";
      if (seconds > 0) text = two_digits(1 / seconds) + " times real time";
      if (seconds > 0 && !brief) text = duration(seconds) + ", " + text;
      wide = std::min(wide, right - start - 0.6 * unit_ - font_.width(text, small));
      texts.push_back(std::move(text));
    }
  }
  const double row = std::min(
      1.75 * unit_, (area.height - 3.4 * unit_) / double(std::max<std::size_t>(costs.size(), 1)));
  if (wide < 4 || row < 2) return;
  const auto length_of = [&](double seconds) {
    return std::max((std::log10(seconds) - low) / std::max(high - low, 1e-9) * wide, 1.0);
  };
  const double top = area.y + 1.9 * unit_, bottom = top + row * double(costs.size());
  double free = start - unit_;  // where the next label may begin
  for (double power = low; power <= high + 1e-9; power += 1) {
    const double x = start + (power - low) / std::max(high - low, 1e-9) * wide;
    picture::fill(faint_, {int(x), int(top), 1, int(bottom - top)}, kLine);
    const std::string text = decade(std::pow(10, power));
    const double half = font_.width(text, small) / 2;
    if (x - half < free) continue;
    font_.draw(faint_, text, x - half, bottom + 1.2 * small, small, kGrey);
    free = x + half + small;
  }
  for (std::size_t i = 0; i < costs.size(); ++i) {
    const ComparedMethod& method = comparison_.methods[i];
    const double line = top + row * (double(i) + 0.5) + 0.36 * size;
    bold_.draw(faint_, method.label, left, line, size, kInk);
    double x = start;
    if (costs[i] > 0) {
      const double bar = length_of(costs[i]);
      picture::fill(faint_,
                    {int(start), int(top + row * (double(i) + 0.2)), int(std::lround(bar)),
                     std::max(int(0.6 * row), 1)},
                    rgb(method.style.color));
      x += bar + 0.5 * unit_;
    }
    font_.draw(faint_, texts[i], x, line, small, kInk);
  }
}

void ComparisonFilm::draw_cursor(picture::Picture& picture, std::size_t instant) {
  const double end = std::max(comparison_.times.back(), 1e-9);
  const int wide = std::max(int(0.1 * unit_), 1);
  for (const Plot& plot : plots_) {
    const auto [left, top, width, height] = plot.area;
    const int x =
        left + int(std::lround(std::min(comparison_.time_of(instant) / end, 1.0) * width));
    for (int y = top; y < plot.area.top(); ++y)
      std::copy_n(full_.at(left, y), std::size_t(x - left) * 4, picture.at(left, y));
    picture::fill(picture, {x, top, wide, height}, kInk, 0.8);
  }
}

// The pictures of a comparison's clip, in their order.

namespace {

constexpr double kStop = 1.1;  // s
constexpr double kCard = 5;    // s
constexpr double kFade = 0.4;  // s, in which the card comes

int frames_of(double seconds, int fps) {
  return std::max(int(std::lround(seconds * fps)), 1);
}

}  // namespace

std::size_t most_moments(std::size_t frames, int fps, int slower, std::size_t methods) {
  const std::size_t stops = methods * std::size_t(frames_of(kStop, fps));
  return frames * std::size_t(slower + 1) + stops + std::size_t(frames_of(kCard, fps));
}

std::vector<Moment> moments_of(const Comparison& comparison) {
  std::vector<Moment> moments;
  const int slower = comparison.slower, stop = frames_of(kStop, comparison.fps);
  if (slower > 1) {
    std::map<std::size_t, std::vector<std::size_t>> stops;  // by instant
    const std::size_t last = comparison.instants() - 1;
    for (std::size_t i = 0; i < comparison.methods.size(); ++i) {
      const Verdict& verdict = comparison.methods[i].verdict;
      if (verdict.grade == Verdict::Grade::none) continue;
      const bool right = verdict.grade == Verdict::Grade::kept;
      stops[right ? last : std::min(verdict.worst * std::size_t(slower), last)].push_back(i);
    }
    for (std::size_t k = 0; k <= last; ++k) {
      moments.push_back({.instant = k, .slower = slower});
      const auto here = stops.find(k);
      if (here == stops.end()) continue;
      // Those that are right share a stop; the others have one each.
      std::vector<std::size_t> right;
      for (const std::size_t i : here->second) {
        if (comparison.methods[i].verdict.grade == Verdict::Grade::kept)
          right.push_back(i);
        else
          moments.insert(moments.end(), std::size_t(stop),
                         {.instant = k, .slower = slower, .stopped = {i}});
      }
      if (!right.empty())
        moments.insert(moments.end(), std::size_t(stop),
                       {.instant = k, .slower = slower, .stopped = right});
    }
  }
  for (std::size_t k = 0; k < comparison.times.size(); ++k)
    moments.push_back({.instant = k * std::size_t(slower)});
  const int card = frames_of(kCard, comparison.fps);
  for (int k = 1; k <= card; ++k)
    moments.push_back({.instant = comparison.instants() - 1,
                       .card = std::min(double(k) / (kFade * comparison.fps), 1.0)});
  return moments;
}

// A comparison's words: names, running numbers, verdicts, the clock, stops and the card.

namespace {

constexpr picture::Rgb kGround{17, 15, 13}, kClause{205, 200, 190};

/// A share in percent, in few letters: "0%", "0.02%", "1.5%", "180%".
std::string percent(double share, bool sign) {
  const double value = 100 * std::abs(share);
  const char* before = value < 0.01 ? "" : share < 0 ? "−" : sign ? "+" : "";
  if (value < 0.01) return "0%";
  if (value < 0.1) return fmt::format("{}{:.2f}%", before, value);
  if (value < 9.95) return fmt::format("{}{:.1f}%", before, value);
  return value < 1e5 ? fmt::format("{}{:.0f}%", before, value)
                     : fmt::format("{}{:.0e}%", before, value);
}

std::string millimetres(double metres) {
  const double mm = 1e3 * metres;
  if (mm < 0.001) return "0 mm";
  return mm < 0.01  ? fmt::format("{:.3f} mm", mm)
         : mm < 100 ? fmt::format("{:.2g} mm", mm)
                    : fmt::format("{:.0f} mm", mm);
}

/// The size at which a line is no wider than `width`, at most `size`.
double fitted(picture::Font& font, const std::string& text, double size, double width) {
  return size * std::clamp(width / std::max(font.width(text, size), 1e-9), 0.2, 1.0);
}

}  // namespace

/// What runs with the clock: the distance from the truth, or energy and stretch.
std::vector<std::string> ComparisonFilm::numbers(const ComparedMethod& method,
                                                 std::size_t instant) const {
  const std::size_t frame = comparison_.frame_of(instant);
  std::vector<std::string> lines;
  if (comparison_.by_truth) {
    if (frame < method.distance.size())
      lines.push_back(millimetres(method.distance[frame]) + " off");
    return lines;
  }
  if (frame < method.energy.size())
    lines.push_back("energy " + percent(method.energy[frame], true));
  if (frame < method.stretch.size())
    lines.push_back("stretch " + percent(method.stretch[frame], false));
  return lines;
}

/// The name in one line, or broken at its dashes.
std::vector<std::string> ComparisonFilm::name_lines(const ComparedMethod& method, double width) {
  const double size = 1.1 * unit_;
  std::vector<std::string> lines{""};
  std::string rest = method.label;
  while (!rest.empty()) {
    const std::size_t end = std::min(rest.find_first_of("-:"), rest.size() - 1) + 1;
    const std::string part = rest.substr(0, end);
    if (!lines.back().empty() && bold_.width(lines.back() + part, size) > width)
      lines.push_back(part);
    else
      lines.back() += part;
    rest.erase(0, end);
  }
  return lines;
}

void ComparisonFilm::draw_header(picture::Picture& picture, const Moment& moment) {
  const picture::Rect& area = areas_.header;
  const double line = area.y + 0.5 * area.height + 0.4 * unit_, gap = 0.6 * unit_;
  const std::string clock = fmt::format("{:.2f} s", comparison_.time_of(moment.instant));
  const std::string speed =
      moment.slower > 1 ? fmt::format("{} times slower", moment.slower) : "real time";
  const double wide = bold_.width("00.00 s", 1.2 * unit_),
               pace = font_.width("00 times slower", 0.9 * unit_);
  double x = area.right() - gap - pace;
  font_.draw(picture, speed, x, line, 0.9 * unit_, kGrey);
  x -= gap + wide;
  bold_.draw(picture, clock, x, line, 1.2 * unit_, kInk);
  const double title = fitted(bold_, comparison_.title, 1.2 * unit_, 0.5 * x);
  bold_.draw(picture, comparison_.title, gap, line, title, kInk);
  const double left = 2 * gap + bold_.width(comparison_.title, title);
  const double size = fitted(font_, comparison_.judged, 0.95 * unit_, x - gap - left);
  font_.draw(picture, comparison_.judged, left, line, size, kGrey);
}

void ComparisonFilm::draw_panel(picture::Picture& picture, std::size_t index, std::size_t instant) {
  const ComparedMethod& method = comparison_.methods[index];
  const auto& [cell, view] = panels_[index];
  const double gap = unit_ / 2, width = cell.width - 2 * gap;
  const bool stopped = is_stopped(method, instant);
  if (stopped) picture::fill(picture, view, kPaper, 0.55);
  picture::fill(picture, {cell.x, cell.y, cell.width, view.y - cell.y}, kPaper);
  picture::fill(picture, {cell.x, cell.y, cell.width, std::max(int(0.3 * unit_), 2)},
                rgb(method.style.color));

  double y = cell.y + 0.35 * unit_;
  double below = 0;  // where the last line of the name ends
  for (const std::string& line : name_lines(method, width)) {
    const double size = fitted(bold_, line, 1.1 * unit_, width);
    bold_.draw(picture, line, cell.x + gap, y += 1.2 * unit_, size, kInk);
    below = bold_.width(line, size);
  }
  const auto lines = numbers(method, instant);
  double x = cell.x + gap;
  const bool beside = width >= 16 * unit_;
  if (!beside || lines.size() > 1 || below + 9 * unit_ > width) y += 1.2 * unit_;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const double size = fitted(font_, lines[i], unit_, width);
    if (lines.size() == 1 && beside) x = cell.right() - gap - font_.width(lines[i], size);
    font_.draw(picture, lines[i], x, y, size, kInk);
    if (beside)
      x += std::max(font_.width(lines[i], size) + unit_, 9 * unit_);
    else
      y += 1.2 * unit_;
  }

  if (stopped) {
    double at = view.y + 0.3 * view.height;
    for (const std::string& text :
         picture::wrapped(font_, method.failure, 0.85 * unit_, width - gap))
      font_.draw(picture, text, cell.x + gap, at += 1.2 * unit_, 0.85 * unit_, kInk);
  }
  if (comparison_.by_truth) {
    const bool known = comparison_.time_of(instant) <= comparison_.horizon;
    const std::string text =
        known ? "ghost: the truth"
              : fmt::format("no truth after {:.2g} s: not predictable", comparison_.horizon);
    const double size = fitted(font_, text, 0.8 * unit_, width);
    const double wide = font_.width(text, size), left = cell.right() - gap - wide;
    picture::fill(
        picture,
        {int(left - 0.4 * size), int(view.y + 0.3 * size), int(wide + 0.8 * size), int(1.4 * size)},
        kPaper, 0.6);
    font_.draw(picture, text, left, view.y + 1.35 * size, size, kGrey);
  }

  picture::fill(picture, {cell.x, view.top(), cell.width, cell.top() - view.top()},
                rgb(method.verdict.grade));
  const double size = verdict_size(cell);
  double at = view.top() - 0.05 * size;
  for (const std::string& text : picture::wrapped(bold_, method.verdict.text, size, width))
    bold_.draw(picture, text, cell.x + gap, at += 1.25 * size, fitted(bold_, text, size, width),
               kPaper);
  for (const int edge : {cell.x, cell.right() - 1})
    picture::fill(picture, {edge, cell.y, 1, cell.height}, kPaper);
}

/// Whose colour is whose, where methods lie over each other: names, running numbers, verdicts.
void ComparisonFilm::draw_list(picture::Picture& picture, std::size_t instant) {
  const picture::Rect& area = areas_.list;
  const std::size_t count = comparison_.methods.size();
  const double row = area.height / (double(count) + 1.5), gap = 0.6 * unit_;
  const double size = std::min(unit_, 0.75 * row);
  double names = 0, figures = 0;
  for (const ComparedMethod& method : comparison_.methods)
    names = std::max(names, bold_.width(method.label, size));
  std::size_t columns = comparison_.by_truth ? 1 : 2;
  figures = font_.width("+0000%", size);
  const double first = area.x + gap + 1.2 * size;
  // All verdicts in letters of one size; numbers where there is room for them.
  double verdict = size;
  const auto left = [&] { return first + names + double(columns) * (figures + gap) + gap; };
  for (const bool roomy : {true, false}) {
    if (!roomy) columns = 0;
    verdict = size;
    for (const ComparedMethod& method : comparison_.methods)
      verdict =
          std::min(verdict, fitted(bold_, method.verdict.text, size, area.right() - gap - left()));
    if (verdict > 0.85 * size) break;
  }
  if (columns == 2) {
    for (std::size_t c = 0; c < 2; ++c) {
      const std::string text = c ? "stretch" : "energy";
      const double end = first + names + double(c + 1) * (figures + gap);
      font_.draw(picture, text, end - font_.width(text, 0.85 * size), area.y + row, 0.85 * size,
                 kGrey);
    }
  }
  double y = area.y + row;
  for (const ComparedMethod& method : comparison_.methods) {
    y += row;
    picture::fill(picture,
                  {int(area.x + gap), int(y - 0.75 * size), int(0.8 * size), int(0.8 * size)},
                  rgb(method.style.color));
    bold_.draw(picture, method.label, first, y, size, kInk);
    const auto lines = numbers(method, instant);
    for (std::size_t c = 0; c < lines.size() && columns > 0; ++c) {
      const std::string value =
          comparison_.by_truth ? lines[c] : lines[c].substr(lines[c].find(' ') + 1);
      const std::size_t column = lines[c].starts_with("stretch") ? 1 : 0;
      const double end = first + names + double(column + 1) * (figures + gap);
      font_.draw(picture, value, end - font_.width(value, size), y, size, kInk);
    }
    bold_.draw(picture, method.verdict.text, left(), y, verdict, rgb(method.verdict.grade));
  }
}

/// A stop at a method's worst moment: its verdict, large.
void ComparisonFilm::draw_stop(picture::Picture& picture, const Moment& moment) {
  const auto& stopped = moment.stopped;
  const ComparedMethod& method = comparison_.methods[stopped.front()];
  const picture::Rgb color = rgb(method.verdict.grade);
  if (layout_ == Layout::beside)
    for (std::size_t i = 0; i < panels_.size(); ++i) {
      const picture::Rect& cell = panels_[i].cell;
      if (std::ranges::find(stopped, i) == stopped.end()) {
        picture::fill(picture, cell, kPaper, 0.7);
        continue;
      }
      const int thick = std::max(int(0.3 * unit_), 2);
      picture::fill(picture, {cell.x, cell.y, cell.width, thick}, color);
      picture::fill(picture, {cell.x, cell.y, thick, cell.height}, color);
      picture::fill(picture, {cell.right() - thick, cell.y, thick, cell.height}, color);
    }
  std::string text;
  for (std::size_t k = 0; k < stopped.size(); ++k)
    text += (k == 0                   ? ""
             : k + 1 < stopped.size() ? ", "
                                      : " and ") +
            comparison_.methods[stopped[k]].label;
  const bool alone = stopped.size() == 1 && !comparison_.by_truth;
  text += (alone ? " " : ": ") + method.verdict.text;
  const picture::Rect& area = areas_.panels;
  const int high = std::min(int(3.4 * unit_), area.height);
  const picture::Rect band{0, area.top() - high, width_, high};
  picture::fill(picture, band, color);
  const double size = fitted(bold_, text, 2.1 * unit_, width_ - 2 * unit_);
  bold_.draw(picture, text, (width_ - bold_.width(text, size)) / 2,
             band.y + 0.5 * high + 0.36 * size, size, kPaper);
}

/// The result in one sentence, a clause in each line.
void ComparisonFilm::draw_card(picture::Picture& picture, double shown) {
  picture::fill(picture, {0, 0, width_, height_}, kGround, 0.94 * shown);
  if (shown < 1) return;
  const double left = 0.08 * width_, width = width_ - 2 * left;
  struct Line {
    std::string text;
    double size;
    std::optional<picture::Rgb> mark;
    bool bold;
  };
  std::vector<Line> lines;
  double high = 0;
  const auto& clauses = comparison_.result;
  for (std::size_t i = 0; i < clauses.size(); ++i) {
    const std::string text = clauses[i] + (i + 1 < clauses.size() ? ";" : ".");
    const auto of = std::ranges::find_if(comparison_.methods, [&](const ComparedMethod& method) {
      return clauses[i].starts_with(method.label + " ") ||
             clauses[i].starts_with(method.label + ": ");
    });
    const Verdict::Grade grade =
        of == comparison_.methods.end() ? Verdict::Grade::none : of->verdict.grade;
    const bool right = grade == Verdict::Grade::kept;
    const double size = (right ? 1.6 : 1.35) * unit_;
    bool first = true;
    for (const std::string& part :
         picture::wrapped(right ? bold_ : font_, text, size, width - 1.6 * size)) {
      lines.push_back({part, size, std::nullopt, right});
      if (std::exchange(first, false)) lines.back().mark = rgb(grade);
      high += 1.6 * size;
    }
  }
  // Smaller where there are more lines than fit.
  const double title = 2.4 * unit_;
  const double scale = std::min(1.0, 0.86 * height_ / (high + 1.6 * title));
  double y = (height_ - scale * (high + 1.6 * title)) / 2 + scale * title;
  bold_.draw(picture, comparison_.title, left, y,
             fitted(bold_, comparison_.title, scale * title, width), kPaper);
  y += 0.4 * scale * title;
  for (const Line& line : lines) {
    const double size = scale * line.size;
    y += 1.6 * size;
    if (line.mark)
      picture::fill(picture, {int(left), int(y - 0.72 * size), int(0.75 * size), int(0.75 * size)},
                    *line.mark);
    (line.bold ? bold_ : font_)
        .draw(picture, line.text, left + 1.4 * size, y, size, line.bold ? kPaper : kClause);
  }
  std::string note = "Times: CPU time for a second of motion";
  if (!comparison_.by_truth &&
      std::ranges::any_of(comparison_.methods,
                          [](const ComparedMethod& method) { return !method.energy.empty(); }))
    note += ". Energy: in % " + comparison_.energy_scale;
  font_.draw(picture, note, left, y + 2.2 * scale * unit_, scale * unit_, {150, 146, 138});
}

namespace {

constexpr double kRoom = 0.08;  // of the picture, on each side

}  // namespace

scenes::CameraView framed(const scenes::CameraView& camera, std::span<const Vec3> points,
                          double aspect, double top) {
  scenes::CameraView view = camera;
  const double distance = (camera.target - camera.position).norm();
  // Turning changes what is seen where: a few rounds settle it.
  for (int round = 0; round < 8; ++round) {
    const Vec3 forward = (view.target - view.position).normalized();
    const Vec3 right = forward.cross(Vec3::UnitY()).normalized(), up = right.cross(forward);
    Eigen::AlignedBox2d seen;  // tangents of the angles
    for (const Vec3& p : points) {
      const Vec3 from = p - view.position;
      const double depth = from.dot(forward);
      if (depth > 0.01 * distance)
        seen.extend(Eigen::Vector2d(from.dot(right), from.dot(up)) / depth);
    }
    if (seen.isEmpty()) return camera;
    const double high = seen.sizes().y() / (1 - top - 2 * kRoom);
    const double wide = seen.sizes().x() / (1 - 2 * kRoom) / aspect;
    const double height = std::max({high, wide, 1e-3});
    view.field_of_view = 2 * std::atan(height / 2);
    const Eigen::Vector2d centre = seen.center() + Eigen::Vector2d(0, height * top / 2);
    view.target =
        view.position + distance * (forward + centre.x() * right + centre.y() * up).normalized();
  }
  return view;
}

double pixels_per_metre(const scenes::CameraView& camera, int height) {
  return height /
         (2 * (camera.target - camera.position).norm() * std::tan(camera.field_of_view / 2));
}

double round_length(double most) {
  const double power = std::pow(10, std::floor(std::log10(most)));
  for (const double times : {5.0, 2.0})
    if (times * power <= most) return times * power;
  return power;
}

}  // namespace taut::film
