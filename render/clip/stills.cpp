#include "render/clip/stills.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <tuple>
#include <vector>

#include "render/base/atomic_file.h"
#include "render/base/interrupt.h"
#include "render/film/contact_sheet.h"
#include "render/picture/paint.h"
#include "render/program/command.h"
#include "scenes/scene/clip_simulation.h"

namespace taut::clips {
namespace {

void write_png(const std::filesystem::path& name, const picture::Picture& picture,
               const picture::PngExtras& extras) {
  const auto bytes = picture::encode_png(picture, extras);
  render::AtomicFile file(name);
  file.write({reinterpret_cast<const char*>(bytes.data()), bytes.size()});
  file.commit();
}

/// The frame that shows a time of the scene best: of those within a frame of it the slowest shot's,
/// of these the nearest. None under a card.
int frame_at(const std::vector<scenes::ClipFrame>& frames, double time, int fps) {
  const auto worth = [&](const scenes::ClipFrame& f) {
    const double off = f.card ? 1e300 : std::abs(f.time - time);
    return std::tuple(off > 1.0 / fps ? off : 0, f.rate, off);
  };
  return int(std::ranges::min_element(frames, {}, worth) - frames.begin());
}

/// The frames of a contact sheet, and how many stand in a row.
std::pair<std::vector<int>, int> on_sheet(const Stills& stills, const scenes::Scene& scene,
                                          const std::vector<scenes::ClipFrame>& frames) {
  std::vector<int> chosen;
  if (!stills.every) {
    for (const scenes::Caption& caption : scene.stage->captions)
      chosen.push_back(frame_at(frames, (caption.from + caption.until) / 2, scene.fps));
    std::ranges::sort(chosen);
    if (chosen.empty()) throw program::Misuse("--contact-sheet: the scene has no captions to show");
    return {chosen, 3};
  }
  for (int i = 0;; ++i) {
    const auto frame = std::lround(i * *stills.every * scene.fps);
    if (frame >= std::ssize(frames)) break;
    chosen.push_back(int(frame));
  }
  return {chosen, int(std::ceil(std::sqrt(double(chosen.size()))))};
}

}  // namespace

std::string make_stills(const Stills& stills, const scenes::Scene& scene, film::Film& film,
                        const std::filesystem::path& out, const options::Provenance& provenance) {
  const std::vector<scenes::ClipFrame> frames = scenes::clip_frames(scene);
  const auto draw_all = [&](const std::vector<int>& wanted, int shrink) {
    const auto open = scenes::record(scene, frames, wanted, render::stop_if_interrupted);
    std::vector<picture::Picture> pictures;
    for (std::size_t i = 0; i < wanted.size(); ++i) {
      render::stop_if_interrupted();
      const scenes::ClipFrame& frame = frames[std::size_t(wanted[i])];
      picture::Picture drawn = film.draw(frame, film.shutter(frame, open[i])).picture;
      pictures.push_back(shrink > 1 ? picture::shrunk(drawn, shrink) : std::move(drawn));
    }
    return pictures;
  };
  std::string made;
  if (stills.contact_sheet || stills.every) {
    const auto [wanted, columns] = on_sheet(stills, scene, frames);
    write_png(out / "contact_sheet.png", film::contact_sheet(draw_all(wanted, columns), columns),
              provenance.picture(frames[std::size_t(wanted.front())].time, false));
    made += (out / "contact_sheet.png").string() + "\n";
  }
  if (stills.poster) {
    const double end = double(frames.size()) / scene.fps;
    if (!(*stills.poster >= 0 && *stills.poster <= end)) {
      throw program::Misuse(
          fmt::format("--poster {}: the clip lasts from 0 to {:g} s", *stills.poster, end));
    }
    const int frame =
        std::min(int(std::lround(*stills.poster * scene.fps)), int(frames.size()) - 1);
    const std::filesystem::path file =
        stills.poster_file.empty() ? out / "poster.png" : std::filesystem::path(stills.poster_file);
    film.set_transparent(stills.transparent);
    write_png(file, draw_all({frame}, 1)[0],
              provenance.picture(frames[std::size_t(frame)].time, stills.transparent));
    made += file.string() + "\n";
  }
  return made;
}

}  // namespace taut::clips
