// Methods in one picture: a panel of the scene for each, or all over each other in one; charts and
// costs under them; the clip that they make, and the camera that frames them.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "render/chart/chart.h"
#include "render/chart/table.h"
#include "render/draw/stage_renderer.h"
#include "render/film/film.h"
#include "render/gl/canvas.h"
#include "render/picture/text.h"
#include "scenes/scene/scene.h"
#include "scenes/scene/stage.h"

namespace taut::film {

// What a comparison says of a method.

/// What is said of a method, in words, and how bad it is.
struct Verdict {
  enum class Grade { kept, off, broken, none };  // none: there is nothing to judge by
  Grade grade = Grade::none;
  std::string text = {};
  std::size_t worst = 0;  // the frame at which it is the farthest off
};

/// The largest error of a method that is right, as a share of what it is measured by: of the energy
/// scale, of the length, of the momentum scale.
inline constexpr double kKept = 0.01;

// Colours of a comparison's text and shapes.

inline constexpr picture::Rgb kInk = {32, 34, 38}, kGrey = {96, 98, 102}, kPaper = {255, 255, 255},
                              kRight = {24, 122, 62}, kOff = {190, 95, 10}, kBroken = {176, 32, 40};

/// Of 0xrrggbb.
inline picture::Rgb rgb(std::uint32_t color) {
  return {std::uint8_t(color >> 16), std::uint8_t(color >> 8), std::uint8_t(color)};
}

inline picture::Rgb rgb(Verdict::Grade grade) {
  switch (grade) {
    case Verdict::Grade::kept:
      return kRight;
    case Verdict::Grade::off:
      return kOff;
    case Verdict::Grade::broken:
      return kBroken;
    case Verdict::Grade::none:
      break;
  }
  return kGrey;
}

/// A method's run of the scene.
struct ComparedMethod {
  std::string label, settings;
  chart::Style style;
  std::vector<Snapshot> states = {};  // at the instants shown (Comparison), as far as it came
  std::size_t frames = 0;             // of the scene, as far as it came
  std::string failure = {};           // why it came no further; empty: it did come to the end
  std::vector<double> distance = {};  // m, mean of its segments from the truth, per frame
  std::vector<double> energy = {};    // share of the scale that it has gained, per frame
  std::vector<double> stretch = {};   // of its worst link, as a share, per frame
  Verdict verdict = {};
  // Of all frames; not a number where there is none.
  double from_constraints = NAN, from_truth = NAN;  // m, the mean from dynamic constraints, truth
  double stretch_max = NAN, drift = NAN;            // shares of a link's length and of the energy
  double cpu_us = NAN;                              // per frame
};

/// Frames are those of the scene. Each is divided into `slower` instants, which slow motion shows:
/// instant `i` belongs to frame i / slower.
struct Comparison {
  std::string title;
  int fps = 60;
  int slower = 1;               // how many times slower than real time the clip begins; 1: not
  std::vector<double> times;    // s, of the frames
  std::vector<Snapshot> truth;  // at the instants
  double horizon = 0;           // s, up to which the truth is predictable
  double self_error = 0;        // m, of the truth
  double length = 0;            // m, of which the distance from the truth may be kKept
  bool by_truth = false;        // verdicts are of the distance from the truth, else of the laws
  std::string judged;           // what by, in a line
  std::string energy_scale;     // in words: 100% of energy
  bool loses = false;           // energy may be lost
  std::vector<ComparedMethod> methods;
  std::vector<std::string> result;  // the clauses of the sentence that sums it up
  chart::Table table;               // a row per method

  std::size_t instants() const { return (times.size() - 1) * std::size_t(slower) + 1; }
  double time_of(std::size_t instant) const { return double(instant) / (slower * double(fps)); }
  std::size_t frame_of(std::size_t instant) const { return instant / std::size_t(slower); }
};

/// A picture of the clip.
struct Moment {
  std::size_t instant = 0;
  int slower = 1;                         // than real time
  std::vector<std::size_t> stopped = {};  // the methods whose verdict is shown large
  double card = 0;                        // how much of the card there is to see, 0 to 1

  bool operator==(const Moment&) const = default;
};

/// The clip. Where `slower` is above 1: slow motion that stops for about a second at the worst
/// moment of each method, and at its end for those that are right; then real time. Then a card.
std::vector<Moment> moments_of(const Comparison& comparison);
/// The most moments that a clip of so many frames and methods can have.
std::size_t most_moments(std::size_t frames, int fps, int slower, std::size_t methods);

enum class Layout {
  beside,  // a panel for each method
  over,    // one panel, where each method's connectors and bodies have its colour
};

/// The pictures of a comparison. Nothing that moves casts a shadow. In each panel the truth is a
/// translucent ghost, up to its horizon, and connectors with one end on a prescribed point have
/// their circle of reach. A method that stopped early stays where it was, and its panel says why.
class ComparisonFilm {
 public:
  /// The scene has a stage; both outlive this. Throws NoContext where the driver allows no such
  /// size or number of samples.
  ComparisonFilm(const gl::Context& context, const scenes::Scene& scene,
                 const Comparison& comparison, int width, int height, int samples,
                 Layout layout = Layout::beside);

  picture::Picture draw(const Moment& moment);

 private:
  struct Panel {
    picture::Rect cell, view;  // all of it, and the part where the scene is seen
  };
  struct Plot {
    picture::Rect area;
    double low = 0, high = 1;  // of the transformed values
  };
  /// A connector's end on a prescribed point.
  struct Tether {
    std::size_t connector;
    bool last;      // particle
    double length;  // m
  };

  void lay_out();
  std::vector<Panel> panels(int columns);
  double verdict_size(const picture::Rect& cell) const;
  scenes::CameraView camera(double time) const;
  std::vector<Vec3> framed_points() const;
  draw::FrameState instant(const Snapshot& state, double time) const;
  const Snapshot& state_of(const ComparedMethod& method, std::size_t instant) const;
  bool is_stopped(const ComparedMethod& method, std::size_t instant) const;
  picture::Picture draw_scene(std::size_t instant);
  void draw_beside(std::span<const draw::View> views, std::size_t instant);
  void draw_over(const draw::View& view, std::size_t instant);
  void draw_reach(picture::Picture& picture, const Panel& panel, const Snapshot& state,
                  double time);
  void draw_scale(picture::Picture& picture);

  void draw_header(picture::Picture& picture, const Moment& moment);
  void draw_panel(picture::Picture& picture, std::size_t method, std::size_t instant);
  void draw_list(picture::Picture& picture, std::size_t instant);
  void draw_stop(picture::Picture& picture, const Moment& moment);
  void draw_card(picture::Picture& picture, double shown);
  std::vector<std::string> numbers(const ComparedMethod& method, std::size_t instant) const;
  std::vector<std::string> name_lines(const ComparedMethod& method, double width);

  enum class Measure { distance, energy, stretch };
  void draw_charts();
  void draw_chart(Measure measure, const picture::Rect& area);
  void draw_costs();
  void draw_cursor(picture::Picture& picture, std::size_t instant);

  const scenes::Scene& scene_;
  const Comparison& comparison_;
  Layout layout_;
  int width_, height_;
  double unit_;  // px, the height of the type
  /// From the upper left corner of the picture.
  struct Areas {
    picture::Rect header, panels, list, charts, costs;
  };
  static Areas areas(int width, int height, double unit, std::size_t methods, Layout layout);
  Areas areas_;
  std::vector<Panel> panels_;                 // from the upper left corner of the picture
  std::optional<scenes::CameraView> camera_;  // none: the scene's
  std::vector<Tether> tethers_;
  Passes passes_;
  gl::Canvas canvas_;
  draw::StageRenderer renderer_;
  std::vector<scenes::Stage> coloured_;  // [method], where they lie over each other
  std::vector<std::unique_ptr<draw::StageRenderer>> overlays_;  // of these
  picture::Font font_, bold_{picture::Font::Weight::bold};
  picture::Picture faint_, full_;  // what is the same in every picture, before and after its time
  std::vector<Plot> plots_;
  std::optional<std::size_t> drawn_;  // the instant of the picture below
  picture::Picture drawn_picture_;
  std::optional<Moment> last_;  // drawn, and its picture
  picture::Picture last_picture_;
};

/// The camera turned and zoomed, not moved, so that all points (m) lie in the picture below `top`,
/// a share of its height, with a small margin. Points behind the camera are ignored. `aspect`:
/// width / height of the picture.
scenes::CameraView framed(const scenes::CameraView& camera, std::span<const Vec3> points,
                          double aspect, double top);

/// Pixels per metre at the distance of the camera's target, in a picture `height` pixels high.
double pixels_per_metre(const scenes::CameraView& camera, int height);

/// The longest length (m) of 1, 2 or 5 times a power of ten that is at most `most`.
double round_length(double most);

}  // namespace taut::film
