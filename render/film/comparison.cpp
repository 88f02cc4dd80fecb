#include "render/film/comparison.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "render/film/comparison_colors.h"
#include "render/film/framing.h"
#include "render/picture/paint.h"

namespace taut::film {
namespace {

constexpr float kGhost = 0.35f;     // opacity
constexpr float kOverlay = 0.85f;   // opacity of methods over each other
constexpr double kCells = 0.63;     // of the picture's height
constexpr double kPanel = 0.46;     // of its width, where methods lie over each other
constexpr double kTable = 0.36;     // of its height, there
constexpr double kHeading = 0.085;  // of the picture's height, over what moves in a cell
constexpr int kMostColumns = 6;
constexpr double kCharts = 0.58;  // of the picture's width; the rest is the table's

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
scenes::Stage coloured(const scenes::Stage& stage, const Vec3& color) {
  scenes::Stage result = stage;
  result.characters.clear();
  for (scenes::ConnectorLook& look : result.connector_looks) look.color = color;
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
std::vector<picture::Rect> cells(std::size_t count, int columns, int width, int height) {
  const int rows = (int(count) + columns - 1) / columns;
  std::vector<picture::Rect> result;
  for (int i = 0; i < int(count); ++i) {
    const int x = width * (i % columns) / columns, y = height * (i / columns) / rows;
    result.push_back(
        {x, y, width * (i % columns + 1) / columns - x, height * (i / columns + 1) / rows - y});
  }
  return result;
}

/// Everything that moves: as the truth has it, and behind its end as the first method does that
/// goes on; where methods lie over each other, as each of them has it.
std::vector<Vec3> moving_points(const Comparison& comparison, Layout layout) {
  std::vector<Vec3> points;
  const auto add = [&](std::span<const Snapshot> states) {
    for (const Snapshot& state : states) {
      for (const auto& particles : state.connectors)
        points.insert(points.end(), particles.begin(), particles.end());
      for (const Pose& body : state.bodies) points.push_back(body.position);
    }
  };
  add(comparison.truth);
  if (layout == Layout::over) {
    for (const ComparedMethod& method : comparison.methods) add(method.frames);
    return points;
  }
  const std::size_t known = comparison.truth.size();
  for (const ComparedMethod& method : comparison.methods) {
    if (known == comparison.times.size() || method.frames.size() <= known) continue;
    add(std::span(method.frames).subspan(known));
    break;
  }
  return points;
}

/// A millimetre value as short as its size allows.
std::string millimetres(double metres) {
  const double mm = 1e3 * metres;
  return mm >= 1e-3 || mm == 0 ? fmt::format("{:.3g} mm", mm) : fmt::format("{:.0e} mm", mm);
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
      areas_(areas(width, height, layout)),
      canvas_(context, areas_.cells.width, areas_.cells.height, samples),
      renderer_(context, *scene.stage, divided(scene.world, scene.timeline)),
      still_(width, height) {
  if (layout_ == Layout::over) {
    for (const ComparedMethod& method : comparison_.methods)
      coloured_.push_back(coloured(*scene.stage, linear(rgb(method.style.color))));
    for (const scenes::Stage& stage : coloured_)
      overlays_.push_back(std::make_unique<draw::StageRenderer>(
          context, stage, divided(scene.world, scene.timeline)));
  }
  lay_out();
  draw_charts();
  draw_table();
}

ComparisonFilm::Areas ComparisonFilm::areas(int width, int height, Layout layout) {
  if (layout == Layout::over) {
    const int right = std::max(int(kPanel * width), 1), low = int((1 - kTable) * height);
    return {{0, 0, right, height},
            {right, 0, width - right, low},
            {right, low, width - right, height - low}};
  }
  const int top = std::max(int(kCells * height), 1), middle = int(kCharts * width);
  return {{0, 0, width, top},
          {0, top, middle, height - top},
          {middle, top, width - middle, height - top}};
}

void ComparisonFilm::lay_out() {
  const std::size_t count = layout_ == Layout::over ? 1 : comparison_.methods.size();
  const int usual = count == 4 ? 2 : std::min(int(count), 3);
  cells_ = cells(count, usual, areas_.cells.width, areas_.cells.height);
  // People, and cameras that move, are seen as the scene has them.
  if (!scene_.stage->characters.empty() || scene_.stage->camera.size() != 1) return;
  const scenes::CameraView camera = scenes::camera_at(scene_.stage->camera, 0);
  const std::vector<Vec3> points = moving_points(comparison_, layout_);
  double best = 0;  // px to a metre
  for (int columns = 1; columns <= std::min(int(count), kMostColumns); ++columns) {
    std::vector<picture::Rect> tried =
        cells(count, columns, areas_.cells.width, areas_.cells.height);
    const picture::Rect& cell = tried.front();
    if (cell.width < 1 || cell.height < 1) continue;
    const scenes::CameraView view = framed(camera, points, double(cell.width) / cell.height,
                                           std::min(kHeading * height_ / cell.height, 0.4));
    const double scale = pixels_per_metre(view, cell.height);
    if (scale <= best) continue;
    best = scale;
    camera_ = view;
    cells_ = std::move(tried);
  }
}

scenes::CameraView ComparisonFilm::camera(double time) const {
  return camera_ ? *camera_ : scenes::camera_at(scene_.stage->camera, time);
}

/// A length in the first cell, as long as it is where the camera looks.
void ComparisonFilm::draw_scale(picture::Picture& picture) {
  if (!camera_) return;
  const picture::Rect& cell = cells_.front();
  const double metre = pixels_per_metre(*camera_, cell.height);
  const double length = round_length(0.4 * cell.width / metre), size = 0.0168 * height_;
  const int wide = std::max(int(std::lround(length * metre)), 1),
            thick = std::max(height_ / 360, 1);
  const int left = cell.x + int(size), bottom = cell.top() - int(2.8 * size);  // above the note
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

picture::Picture ComparisonFilm::draw(std::size_t frame) {
  const double time = comparison_.times[frame];
  std::vector<draw::View> views;
  for (const picture::Rect& cell : cells_)
    views.push_back(
        {{cell.x, areas_.cells.height - cell.top(), cell.width, cell.height}, camera(time)});
  renderer_.begin(canvas_, views);
  if (layout_ == Layout::over)
    draw_over(views.front(), frame);
  else
    draw_beside(views, frame);
  picture::Picture picture = still_;
  picture::paste(canvas_.finish(), picture, 0, 0);
  for (const picture::Rect& cell : cells_) draw_truth_note(picture, cell, frame);
  if (layout_ == Layout::over)
    draw_legend(picture, frame);
  else
    for (std::size_t i = 0; i < cells_.size(); ++i) draw_cell(picture, i, frame);
  draw_scale(picture);
  draw_cursor(picture, frame);
  return picture;
}

const Snapshot& ComparisonFilm::state_of(const ComparedMethod& method, std::size_t frame) const {
  const std::size_t last = std::min(frame + 1, method.frames.size());
  return last ? method.frames[last - 1] : comparison_.truth.front();
}

void ComparisonFilm::draw_beside(std::span<const draw::View> views, std::size_t frame) {
  const double time = comparison_.times[frame];
  for (std::size_t i = 0; i < views.size(); ++i) {
    const Snapshot& state = state_of(comparison_.methods[i], frame);
    renderer_.draw(canvas_, views[i].viewport, instant(state, time));
    if (time <= comparison_.horizon)
      renderer_.draw(canvas_, views[i].viewport, instant(comparison_.truth[frame], time),
                     {.characters = false, .opacity = kGhost});
  }
}

void ComparisonFilm::draw_over(const draw::View& view, std::size_t frame) {
  const double time = comparison_.times[frame];
  const bool known = time <= comparison_.horizon;
  const Snapshot& shown =
      known ? comparison_.truth[frame] : state_of(comparison_.methods.front(), frame);
  renderer_.draw(canvas_, view.viewport, instant(shown, time),
                 {.bodies = false, .connectors = false});
  for (std::size_t i = 0; i < overlays_.size(); ++i)
    overlays_[i]->draw(canvas_, view.viewport,
                       instant(state_of(comparison_.methods[i], frame), time),
                       {.characters = false, .opacity = kOverlay});
  if (known)
    renderer_.draw(canvas_, view.viewport, instant(comparison_.truth[frame], time),
                   {.characters = false, .opacity = kGhost});
}

/// Whose colour is whose, and how far each is from what distances are measured from.
void ComparisonFilm::draw_legend(picture::Picture& picture, std::size_t frame) {
  const picture::Rect& cell = cells_.front();
  const double size = 0.024 * height_, row = 1.6 * size;
  double column = 0;
  for (const ComparedMethod& method : comparison_.methods)
    column = std::max(column, bold_.width(method.label, size));
  double y = cell.y + 1.2 * row;
  const double values = font_.width("0.00000 mm", size);
  picture::fill(picture,
                {int(cell.x), int(cell.y), int(column + values + 4.4 * size),
                 int(row * (double(comparison_.methods.size()) + 1))},
                kPaper, 0.72);
  for (const ComparedMethod& method : comparison_.methods) {
    const bool stopped = !method.failure.empty() && frame >= method.frames.size();
    picture::fill(picture,
                  {int(cell.x + size), int(y - 0.7 * size), int(0.8 * size), int(0.8 * size)},
                  rgb(method.style.color));
    bold_.draw(picture, method.label, cell.x + 2.4 * size, y, size, kInk);
    const std::string text = stopped                          ? "stopped"
                             : frame < method.distance.size() ? millimetres(method.distance[frame])
                                                              : "";
    font_.draw(picture, text, cell.x + column + 3.4 * size, y, size, kGrey);
    y += row;
  }
}

/// Behind the truth's horizon a cell says that the ghost is gone, and why.
void ComparisonFilm::draw_truth_note(picture::Picture& picture, const picture::Rect& cell,
                                     std::size_t frame) {
  const double time = comparison_.times[frame];
  const std::string text =
      time <= comparison_.horizon
          ? "ghost: the truth"
          : fmt::format("no truth after {:.2g} s: not predictable", comparison_.horizon);
  double size = 0.0168 * height_;
  size *= std::min(1.0, (cell.width - 2 * size) / font_.width(text, size));
  const double wide = font_.width(text, size);
  const double x = std::max(cell.right() - size - wide, double(cell.x) + size);
  picture::fill(
      picture,
      {int(x - 0.4 * size), int(cell.top() - 2 * size), int(wide + 0.8 * size), int(1.4 * size)},
      kPaper, 0.6);
  font_.draw(picture, text, x, cell.top() - size, size,
             time <= comparison_.horizon ? kGrey : picture::Rgb{150, 60, 20});
}

void ComparisonFilm::draw_cell(picture::Picture& picture, std::size_t index, std::size_t frame) {
  const ComparedMethod& method = comparison_.methods[index];
  const picture::Rect& cell = cells_[index];
  const double size = 0.021 * height_, small = 0.8 * size, gap = 0.5 * size;
  const bool stopped = !method.failure.empty() && frame >= method.frames.size();
  if (stopped) picture::fill(picture, cell, kPaper, 0.55);

  const int bar = std::max(height_ / 180, 1);
  picture::fill(picture, {cell.x, cell.y, cell.width, bar}, rgb(method.style.color));
  for (const int x : {cell.x, cell.right() - 1})
    picture::fill(picture, {x, cell.y, 1, cell.height}, kPaper, 0.8);
  const double line = cell.y + bar + gap + size;
  const auto lines = picture::wrapped(font_, method.settings, small, cell.width - 2 * gap);
  const double band = bar + 1.8 * gap + size + 1.3 * small * double(lines.size());
  picture::fill(picture, {cell.x, cell.y + bar, cell.width, int(band) - bar}, kPaper, 0.72);
  bold_.draw(picture, method.label, cell.x + gap, line, size, kInk);
  for (std::size_t k = 0; k < lines.size(); ++k)
    font_.draw(picture, lines[k], cell.x + gap, line + 1.3 * small * double(k + 1), small, kGrey);

  if (stopped) {
    double y = cell.y + 0.45 * cell.height;
    const double reached = method.frames.empty() ? 0 : method.frames.back().time;
    bold_.draw(picture, fmt::format("Stopped after {:.3g} s", reached), cell.x + 2 * gap, y, size,
               {170, 20, 20});
    for (const std::string& text :
         picture::wrapped(font_, method.failure, small, cell.width - 4 * gap))
      font_.draw(picture, text, cell.x + 2 * gap, y += 1.4 * small, small, kInk);
  } else if (frame < method.distance.size()) {
    const std::string text = millimetres(method.distance[frame]);
    const double wide = font_.width(text, size);
    // Beside the label where there is room, else under the band.
    const bool room = bold_.width(method.label, size) + wide + 3 * gap < cell.width;
    font_.draw(picture, text, cell.right() - gap - wide, room ? line : cell.y + band + 1.3 * size,
               size, kInk);
  }
}

}  // namespace taut::film
