// Methods in one picture: a cell of the scene for each, or all over each other in one; charts and a
// table under them.
#pragma once

#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "render/chart/chart.h"
#include "render/chart/table.h"
#include "render/draw/stage_renderer.h"
#include "render/gl/canvas.h"
#include "render/picture/text.h"
#include "scenes/scene/scene.h"

namespace taut::film {

/// A method's run of the scene.
struct ComparedMethod {
  std::string label, settings;
  chart::Style style;
  std::vector<Snapshot> frames = {};  // as far as it came
  std::string failure = {};           // why it came no further; empty: it did come to the end
  std::vector<double> distance =
      {};  // m, mean of its segments from those of Comparison::measured_from
  std::vector<double> stretch = {};  // of its worst link, as a share, per frame
  // Of all frames; not a number where there is none.
  double from_constraints = NAN, from_truth = NAN;  // m, the mean from dynamic constraints, truth
  double stretch_max = NAN, drift = NAN;            // shares of a link's length and of the energy
  double cpu = NAN;                                 // s per frame
};

struct Comparison {
  std::vector<double> times;    // s, of the frames
  std::vector<Snapshot> truth;  // at those times
  double horizon = 0;           // s, up to which the truth is predictable
  std::string measured_from;    // what the first chart shows distances from
  double self_error = 0;        // m, of the truth
  std::vector<ComparedMethod> methods;
  chart::Table table;  // a row per method
};

enum class Layout {
  beside,  // a cell for each method
  over,    // one cell, where each method's connectors and bodies have its colour and no shadow
};

/// The frames of a comparison. In each cell the truth is a translucent ghost, up to its horizon;
/// behind it the cell says that there is none. A method that stopped early stays where it was, and
/// its cell says why.
class ComparisonFilm {
 public:
  /// The scene has a stage; both outlive this. Throws NoContext where the driver allows no such
  /// size or number of samples, and CannotWrite where gnuplot is missing.
  ComparisonFilm(const gl::Context& context, const scenes::Scene& scene,
                 const Comparison& comparison, int width, int height, int samples,
                 Layout layout = Layout::beside);

  picture::Picture draw(std::size_t frame);

 private:
  /// Cells and a camera that show what moves as large as it can be.
  void lay_out();
  scenes::CameraView camera(double time) const;
  void draw_scale(picture::Picture& picture);
  draw::FrameState instant(const Snapshot& state, double time) const;
  void draw_beside(std::span<const draw::View> views, std::size_t frame);
  void draw_over(const draw::View& view, std::size_t frame);
  const Snapshot& state_of(const ComparedMethod& method, std::size_t frame) const;
  void draw_cell(picture::Picture& picture, std::size_t method, std::size_t frame);
  void draw_legend(picture::Picture& picture, std::size_t frame);
  void draw_truth_note(picture::Picture& picture, const picture::Rect& cell, std::size_t frame);
  void draw_charts();
  void draw_table();
  void draw_cursor(picture::Picture& picture, std::size_t frame);

  const scenes::Scene& scene_;
  const Comparison& comparison_;
  Layout layout_;
  int width_, height_;
  struct Areas {
    picture::Rect cells, charts,
        table;  // from the upper left corner of the picture, where the cells begin
  };
  static Areas areas(int width, int height, Layout layout);
  Areas areas_;
  std::vector<picture::Rect> cells_;          // from the upper left corner of the picture
  std::optional<scenes::CameraView> camera_;  // none: the scene's
  gl::Canvas canvas_;
  draw::StageRenderer renderer_;
  std::vector<scenes::Stage> coloured_;  // [method], where they lie over each other
  std::vector<std::unique_ptr<draw::StageRenderer>> overlays_;  // of these
  picture::Font font_, bold_{picture::Font::Weight::bold};
  picture::Picture still_;  // what is the same in every frame
  std::vector<chart::PlotArea> plots_;
};

}  // namespace taut::film
