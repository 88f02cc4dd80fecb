#include "scenes/scene/scene.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>

#include "sim/motion/stop.h"

namespace taut::scenes {

int frame_count(double duration, int fps) {
  const double count = duration * fps, nearest = std::round(count);
  return static_cast<int>(std::abs(count - nearest) < 1e-9 * count ? nearest : std::ceil(count));
}

int Scene::frames() const {
  return frame_count(duration, fps);
}

Simulation start(const Scene& scene) {
  return start(scene, scene.method);
}

Simulation start(const Scene& scene, const MethodChoice& method) {
  return {scene.world, make_method(method.name, method.settings), scene.timeline};
}

void settle_breaks(Scene& scene) {
  settle_breaks(scene, scene.method);
}

void settle_breaks(Scene& scene, const MethodChoice& method) {
  const auto may_break = [](const Connector& one) { return std::isfinite(one.breaks_at); };
  if (std::ranges::none_of(scene.world.connectors, may_break)) return;
  Simulation simulation = start(scene, method);
  try {
    for (int frame = 0; frame < scene.frames(); ++frame) {
      check_stop();
      simulation.advance_to(static_cast<double>(frame) / scene.fps);
    }
  } catch (const Diverged&) {  // the scene's own run does as well
  }
  scene.breaks = simulation.breaks();
  for (const Simulation::Break& found : scene.breaks) {
    TimedCut& cut = scene.timeline.cuts.emplace_back(found.cut);
    cut.source = "breaks_at of " + found.connector;
  }
  for (Connector& connector : scene.world.connectors) {
    connector.breaks_at = std::numeric_limits<double>::infinity();
  }
}

MethodChoice default_method() {
  return {"direct", {}};
}

std::optional<double> dividing_step(double step, int fps) {
  // A step is the longest allowed. The next shorter one that divides the frame stands for it where
  // the two are within 2%, as 1/1020 s does for 0.001 s at 60 frames per second.
  const double fitted = 1 / (fps * std::ceil(1 / (fps * step) - 1e-6));
  if (std::abs(fitted - step) > 0.02 * step) return {};
  return fitted;
}

std::string dividing_text(double step, int fps) {
  const double count = std::ceil(1 / (fps * step));
  return fmt::format("a step that divides the frame of 1/{} s, such as {:.12g} (1/{} s)", fps,
                     1 / (fps * count), fps * count);
}

namespace {

/// With two digits, never nearer than it is: rounded `up`, or down.
std::string two_digits(double value, bool up) {
  if (!(value > 0) || !std::isfinite(value)) return fmt::format("{:g}", value);
  const double unit = std::pow(10, std::floor(std::log10(value)) - 1);
  constexpr double kWhole = 1e-9;
  const double units = value / unit;
  return fmt::format("{:.2g}",
                     unit * (up ? std::ceil(units - kWhole) : std::floor(units + kWhole)));
}

}  // namespace

std::optional<Length> read_length(std::string_view text) {
  Length length;
  const auto [unit, error] = std::from_chars(text.data(), text.data() + text.size(), length.number);
  if (error != std::errc() || !(length.number > 0) || !std::isfinite(length.number)) return {};
  length.unit = text.substr(static_cast<std::size_t>(unit - text.data()));
  if (length.unit != "px" && length.unit != "mm") return {};
  return length;
}

std::string certificate(const Plan& plan) {
  const std::size_t unit = plan.tolerance.find_first_not_of("0123456789.e-+");
  std::string text;
  if (plan.until > 0) {
    text = fmt::format("within {} {} of the reference solution until {} s{}",
                       two_digits(plan.error, true),
                       plan.tolerance.substr(std::min(unit, plan.tolerance.size())),
                       two_digits(plan.until, false), plan.end.empty() ? "" : ", when " + plan.end);
  } else {
    text = "of an unpredictable motion";
  }
  if (const auto& later = plan.afterwards) {
    using Work = Plan::Afterwards::Work;
    constexpr double kLeastShown = 1e-8;
    const auto share = [&](double of) {
      return two_digits(100 * (of > 0 ? std::max(of, kLeastShown) : 0), true) + "%";
    };
    text += fmt::format("; {}{}energy{} within {}, stretch within {}, speeds within {}",
                        plan.until > 0 ? "afterwards " : "",
                        later->work == Work::unknown ? "mean " : "",
                        later->work == Work::known ? ", less the work of what drives it," : "",
                        share(later->energy), share(later->stretch), share(later->speeds));
  }
  return text;
}

}  // namespace taut::scenes
