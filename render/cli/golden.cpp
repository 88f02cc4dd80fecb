// taut golden: pictures that are kept, and compared with what their scenes look like now.
#include "render/golden.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "render/atomic_file.h"
#include "render/cli/command.h"
#include "render/cli/method_options.h"
#include "render/cli/progress.h"
#include "render/film.h"
#include "render/golden_page.h"
#include "render/interrupt.h"
#include "scenes/error.h"
#include "scenes/golden_suite.h"
#include "sim/simulation.h"

namespace taut::cli {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

struct Options {
  std::string action, folder, out, backend = "auto";
  std::vector<std::string> only;
  bool simulate = false;
};

/// A scene that is ready to be drawn.
struct Set {
  Scene scene;
  Film film;
  Set(const Context& context, const GoldenSuite& suite, const GoldenFrame& frame)
      : scene(staged(frame)), film(context, scene, suite.width, suite.height, suite.samples) {}

  static Scene staged(const GoldenFrame& frame) {
    Scene scene = load_scene(frame.scene, true);
    if (!scene.stage)
      throw BadScene(fmt::format("{}: {} has no [stage], so there is nothing to draw", frame.source,
                                 frame.scene.string()));
    return scene;
  }
};

/// What became of one frame.
struct Result {
  Judgement judgement;
  double distance = 0;  // m, of today's state from the kept one
  std::string failure;  // empty: as it should be
  std::optional<Picture> actual, golden;
};

Snapshot simulate(const Scene& scene, const GoldenFrame& frame) {
  Simulation simulation = start(scene, frame.method);
  for (int k = 1; k <= frame.frame; ++k) {
    stop_if_interrupted();
    simulation.advance_to(double(k) / scene.fps);
  }
  return simulation.state();
}

/// The largest distance between like points, m; none where the states are not of one world.
std::optional<double> distance(const Snapshot& a, const Snapshot& b) {
  if (a.connectors.size() != b.connectors.size() || a.bodies.size() != b.bodies.size()) return {};
  double largest = 0;
  for (std::size_t c = 0; c < a.connectors.size(); ++c) {
    if (a.connectors[c].size() != b.connectors[c].size()) return {};
    for (std::size_t i = 0; i < a.connectors[c].size(); ++i)
      largest = std::max(largest, (a.connectors[c][i] - b.connectors[c][i]).norm());
  }
  for (std::size_t i = 0; i < a.bodies.size(); ++i)
    largest = std::max(largest, (a.bodies[i].position - b.bodies[i].position).norm());
  return largest;
}

class Goldens {
 public:
  Goldens(const Options& options, const Common& common)
      : suite_(load_golden_suite(options.folder)),
        context_(backend_named(options.backend), common.threads),
        renderer_(renderer_of(context_.description())) {
    if (options.only.empty()) return;
    for (const std::string& name : options.only)
      if (std::ranges::find(suite_.frames, name, &GoldenFrame::name) == suite_.frames.end())
        throw Misuse(fmt::format("--only {}: {} has no such frame", name, options.folder));
    std::erase_if(suite_.frames, [&](const GoldenFrame& frame) {
      return std::ranges::find(options.only, frame.name) == options.only.end();
    });
  }

  const std::vector<GoldenFrame>& frames() const { return suite_.frames; }

  Result check(const GoldenFrame& frame) {
    Result result;
    if (!fs::exists(file(frame, ".json")) || !fs::exists(file(frame, ".png"))) {
      result.failure = "nothing is kept of it yet; look at it, and accept it";
      return result;
    }
    const GoldenRecord record = read_golden(file(frame, ".json"));
    Set& set = set_of(frame);
    const Snapshot today = simulate(set.scene, frame);
    const std::optional<double> off = distance(today, record.state);
    if (!off) {
      result.failure =
          "the scene has other particles or bodies than the kept state; accept it with --simulate";
      return result;
    }
    result.distance = *off;
    result.golden = picture_of(frame);
    result.actual = set.film.draw(set.film.instant(record.state));
    result.judgement = judge(*result.actual, renderer_, *result.golden, record);
    const PictureDifference& d = result.judgement.difference;
    if (!result.judgement.same)
      result.failure = fmt::format(
          "{:.3g}% of its pixels differ by more than 2, at most by {}, means by {:.2g}; "
          "{:.3g}% have nothing like them next to them (judged as: {})",
          100 * d.above_2, d.largest, d.mean_shift, 100 * d.near_above_8,
          name_of(result.judgement.tier));
    if (!(result.distance <= frame.within))
      result.failure +=
          fmt::format("{}the simulation ends {:.3g} m from the kept state, {:.3g} m allowed",
                      result.failure.empty() ? "" : "; ", result.distance, frame.within);
    return result;
  }

  /// Keeps what the frame looks like now. Says what changed.
  std::string accept(const GoldenFrame& frame, bool simulate_anew) {
    Set& set = set_of(frame);
    const bool kept = fs::exists(file(frame, ".json")) && fs::exists(file(frame, ".png"));
    GoldenRecord record;
    if (kept && !simulate_anew) record = read_golden(file(frame, ".json"));
    if (!kept || simulate_anew || !distance(start(set.scene).state(), record.state))
      record.state = simulate(set.scene, frame);
    const Picture picture = set.film.draw(set.film.instant(record.state));
    std::string change = "new";
    if (kept) {
      const Picture before = picture_of(frame);
      change = before.pixels == picture.pixels ? "as before" : "changed";
    }
    record.renderer = renderer_;
    record.pixels = pixel_hash(picture);
    write_picture(file(frame, ".png"), picture);
    write_text(file(frame, ".json"), golden_text(record));
    return change;
  }

  static void write_picture(const fs::path& name, const Picture& picture) {
    const auto bytes = encode_png(picture);
    write_text(name, {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
  }
  static void write_text(const fs::path& name, std::string_view text) {
    AtomicFile file(name);
    file.write(text);
    file.commit();
  }

 private:
  fs::path file(const GoldenFrame& frame, const char* extension) const {
    return suite_.folder / (frame.name + extension);
  }

  Picture picture_of(const GoldenFrame& frame) const {
    Picture picture = read_png(file(frame, ".png"));
    if (picture.width != suite_.width || picture.height != suite_.height)
      throw BadAsset(fmt::format("{}: is of {}x{} pixels, expected {}x{}",
                                 file(frame, ".png").string(), picture.width, picture.height,
                                 suite_.width, suite_.height));
    return picture;
  }

  /// The scene of a frame; frames that follow each other share it.
  Set& set_of(const GoldenFrame& frame) {
    if (!set_ || set_->scene.file != frame.scene) {
      set_.reset();
      set_ = std::make_unique<Set>(context_, suite_, frame);
    }
    return *set_;
  }

  GoldenSuite suite_;
  Context context_;
  Renderer renderer_;
  std::unique_ptr<Set> set_;
};

int check(Goldens& goldens, const fs::path& out, const Common& common) {
  Json frames = Json::array();
  std::vector<GoldenFailure> failures;
  {
    Progress progress("checking", "pictures", goldens.frames().size(), common.quiet);
    for (const GoldenFrame& frame : goldens.frames()) {
      stop_if_interrupted();
      const Result result = goldens.check(frame);
      const fs::path folder = out / frame.name;
      fs::remove_all(folder);
      if (!result.failure.empty()) {
        failures.push_back({frame.name, result.failure, result.actual.has_value()});
        if (result.actual) {
          Goldens::write_picture(folder / "actual.png", *result.actual);
          Goldens::write_picture(folder / "golden.png", *result.golden);
          Goldens::write_picture(folder / "difference.png",
                                 amplified_difference(*result.actual, *result.golden));
        }
      }
      const PictureDifference& d = result.judgement.difference;
      frames.push_back({{"name", frame.name},
                        {"scene", frame.scene.string()},
                        {"frame", frame.frame},
                        {"method", frame.method.name},
                        {"settings", settings_json(full_settings(frame.method))},
                        {"same", result.failure.empty()},
                        {"failure", result.failure},
                        {"judged_as", name_of(result.judgement.tier)},
                        {"share_above_2", d.above_2},
                        {"largest", d.largest},
                        {"mean_shift", d.mean_shift},
                        {"share_unlike_neighbours", d.near_above_8},
                        {"state_distance", result.distance}});
      progress.update(frames.size());
    }
  }
  const std::string report = Json({{"failed", failures.size()}, {"frames", frames}}).dump(2) + "\n";
  Goldens::write_text(out / "report.json", report);
  if (failures.empty()) {
    fs::remove(out / "index.html");
  } else {
    Goldens::write_text(out / "index.html", golden_page(failures));
  }
  std::string text;
  for (const GoldenFailure& failure : failures)
    text += fmt::format("{}: {}\n", failure.name, failure.verdict);
  text += failures.empty() ? fmt::format("{} as kept\n", frames.size())
                           : fmt::format("{} of {} differ: {}\n", failures.size(), frames.size(),
                                         (out / "index.html").string());
  write_output(common.json ? report : text);
  return failures.empty() ? kDone : kGoldenDiffers;
}

int run(const Options& options, const Common& common) {
  Goldens goldens(options, common);
  fs::path folder = fs::path(options.folder).lexically_normal();
  if (!folder.has_filename()) folder = folder.parent_path();
  if (options.action == "check")
    return check(
        goldens,
        options.out.empty() ? fs::path("out/golden") / folder.filename() : fs::path(options.out),
        common);
  Json accepted = Json::object();
  std::string text;
  for (const GoldenFrame& frame : goldens.frames()) {
    stop_if_interrupted();
    const std::string change = goldens.accept(frame, options.simulate);
    accepted[frame.name] = change;
    text += fmt::format("{}: {}\n", frame.name, change);
  }
  write_output(common.json ? accepted.dump(2) + "\n" : text);
  return kDone;
}

}  // namespace

void add_golden(CLI::App& app, Program& program) {
  CLI::App& command =
      add_command(app, program, "golden", "Pictures that are kept, and compared with today's",
                  R"(  taut golden check tests/golden/scenes
  taut golden accept tests/golden/scenes --only throw

A golden.toml in the folder names the pictures:
  size = [320, 180]
  [frames.throw]
  scene = "scenes/nunchaku.toml"
  time = 2.7
  method = { name = "direct", tolerance = 1e-5 }  # default: the scene's
  within = 1e-3                                   # m; default 1e-6

`check` draws each from its kept state and compares: every pixel on the driver and processor that
accepted it, by tolerance on others. It also simulates the scene, and fails where that ends further
than `within` from the kept state. What differs is left in out/golden: pictures, report.json, and
index.html to look at. `accept` takes over what the frames look like now.)");
  const auto options = std::make_shared<Options>();
  command.add_option("action", options->action, "check or accept")
      ->required()
      ->check(CLI::IsMember({"check", "accept"}));
  command.add_option("folder", options->folder, "The folder with golden.toml")->required();
  command.add_option("--only", options->only, "Only this frame; may be repeated")
      ->allow_extra_args(false);
  command.add_option("--out", options->out, "Where to leave what differs; default out/golden/NAME");
  command.add_flag("--simulate", options->simulate, "accept: simulate kept states anew, too");
  command.add_option("--backend", options->backend, "auto, egl or osmesa")
      ->check(CLI::IsMember({"auto", "egl", "osmesa"}));
  command.callback([options, &program] {
    program.run = [options, &program] { return run(*options, program.common); };
  });
}

}  // namespace taut::cli
