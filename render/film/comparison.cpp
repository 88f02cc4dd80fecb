#include "render/film/comparison.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "render/film/comparison_colors.h"
#include "render/film/framing.h"
#include "render/picture/paint.h"
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
      canvas_(context, areas_.panels.width, areas_.panels.height, samples),
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
  renderer_.begin(canvas_, visible);
  if (layout_ == Layout::over) {
    if (!visible.empty()) draw_over(visible.front(), at);
  } else {
    draw_beside(views, at);
  }
  drawn_picture_ = canvas_.finish();
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

}  // namespace taut::film
