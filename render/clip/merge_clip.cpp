// The clip from the frames that its parts drew.
#include <fmt/format.h>

#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "render/base/atomic_file.h"
#include "render/base/interrupt.h"
#include "render/clip/clip_job.h"
#include "render/film/film.h"
#include "scenes/files/regular_file.h"

namespace taut::clips {
namespace {

/// The results of a part that is done.
struct DonePart {
  std::filesystem::path folder;
  film::FrameFolder::Entries frames;
  std::uint64_t shared = 0;  // what its frames have in common with others of its renderer
  FramesMade made;           // by its last run
};

std::vector<DonePart> done_parts(const ClipJob& job, const std::vector<program::PartPath>& found) {
  std::vector<DonePart> parts;
  for (const program::PartPath& part : found) {
    render::stop_if_interrupted();
    const std::filesystem::path record = part.path / kRecord;
    std::error_code error;
    if (!std::filesystem::exists(record, error)) continue;  // it is not done
    const std::optional<FramesMade> made = frames_made(scenes::read_bytes(record));
    if (!made) continue;
    DonePart done{part.path, film::FrameFolder::whole_frames(part.path, job.size()), 0, *made};
    done.shared = job.fingerprint(made->renderer);
    parts.push_back(std::move(done));
  }
  return parts;
}

}  // namespace

std::optional<FramesMade> frames_made(const std::string& record) {
  const auto json = nlohmann::json::parse(record, nullptr, false);
  if (!json.is_object()) return {};
  FramesMade made;
  try {
    made.renderer = json.value("renderer", "");
    made.drawn = json.value("frames_drawn", std::size_t(0));
    const double drawn = double(made.drawn);
    made.exposures = json.value("mean_exposures", 0.0) * drawn;
    made.drawing =
        json.value(nlohmann::json::json_pointer("/seconds_per_frame/rendering"), 0.0) * drawn;
  } catch (const nlohmann::json::exception&) {  // a key is of another type
    return {};
  }
  return made;
}

int merge_clip(const ClipJob& job, const program::Common& common) {
  const std::vector<program::PartPath> found = program::found_parts(job.out, kParts);
  const std::vector<DonePart> parts = done_parts(job, found);
  studies::SelfEstimate estimate(job.scene, !job.options.no_estimate && !parts.empty());
  std::vector<const DonePart*> owners(job.frames.size());
  std::vector<std::uint64_t> inputs(job.frames.size());
  ClipStates states(job, estimate);
  while (!parts.empty() && !states.done()) {
    const scenes::ClipSimulation::Shutter open = states.next();
    const std::size_t i = open.index;
    const scenes::ClipFrame& frame = job.clip[std::size_t(job.frames[i])];
    const std::vector<draw::FrameState> shutter = film::shutter_of(job.scene, frame, open);
    for (const DonePart& part : parts) {
      const auto entry = part.frames.find(job.frames[i]);
      if (owners[i] || entry == part.frames.end()) continue;
      inputs[i] = frame_inputs(part.shared, frame, shutter);
      if (entry->second.inputs == inputs[i]) owners[i] = &part;
    }
  }
  std::vector<std::size_t> missing;
  std::set<const DonePart*> used;
  for (std::size_t i = 0; i < owners.size(); ++i) {
    if (!owners[i]) missing.push_back(i);
    used.insert(owners[i]);
  }
  program::require_all(missing, job.frames.size(), program::Share::neighbours, found, job.out,
                       "frames");

  film::FrameFolder folder(job.frame_path, true, job.size());
  FramesMade made;
  for (const DonePart& part : parts) {
    if (!used.contains(&part)) continue;
    made.drawn += part.made.drawn;
    made.exposures += part.made.exposures;
    made.drawing += part.made.drawing;
    if (made.renderer.find(part.made.renderer) != std::string::npos) continue;
    made.renderer += (made.renderer.empty() ? "" : "; ") + part.made.renderer;
  }
  for (std::size_t i = 0; i < owners.size(); ++i) {
    render::stop_if_interrupted();
    const int frame = job.frames[i];
    if (folder.has(frame, inputs[i])) continue;
    folder.take(frame, owners[i]->frames.at(frame),
                film::FrameFolder::file(owners[i]->folder, frame));
  }
  made.simulating = states.time();
  nlohmann::ordered_json report = clip_report(job, made);
  finish_clip(job, report, estimate, common);
  render::write_output(result_text(report, common));
  return program::kDone;
}

}  // namespace taut::clips
