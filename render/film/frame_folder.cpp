#include "render/film/frame_folder.h"

#include <fcntl.h>
#include <fmt/format.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <iterator>
#include <new>
#include <string>
#include <system_error>

#include "render/base/error.h"
#include "scenes/files/files.h"
#include "sim/motion/hash.h"

namespace taut::film {
namespace {

void add(Hash& hash, const Vec3& v) {
  hash.number(v.x()).number(v.y()).number(v.z());
}

void add(Hash& hash, const Pose& pose) {
  add(hash, pose.position);
  const Quat& q = pose.rotation;
  hash.number(q.w()).number(q.x()).number(q.y()).number(q.z());
}

void add(Hash& hash, const scenes::Model& model) {
  for (const scenes::Texture& t : model.textures) {
    hash.number(t.width).number(t.height).number(t.wrap_u).number(t.wrap_v);
    hash.number(t.magnify).number(t.minify).bytes(t.pixels.data(), t.pixels.size());
  }
  for (const scenes::Material& m : model.materials)
    hash.text(m.name).number(m.texture).number(m.base_color).number(m.roughness).number(m.metallic);
  for (const scenes::Mesh& mesh : model.meshes) {
    hash.number(mesh.material).number(mesh.vertices.size());
    for (const scenes::Vertex& v : mesh.vertices)
      hash.number(v.position)
          .number(v.normal)
          .number(v.color)
          .number(v.uv)
          .number(v.bones)
          .number(v.weights);
    hash.number(mesh.indices.size())
        .bytes(mesh.indices.data(), mesh.indices.size() * sizeof mesh.indices[0]);
  }
  for (const scenes::Bone& bone : model.bones)
    for (const float entry : bone.inverse_bind.reshaped()) hash.number(entry);
}

void add(Hash& hash, const std::vector<std::shared_ptr<const scenes::Model>>& models) {
  hash.number(models.size());
  for (const auto& model : models) {
    hash.number(model != nullptr);
    if (model) add(hash, *model);
  }
}

}  // namespace

std::uint64_t program_fingerprint() {
  const std::string bytes = scenes::read_bytes("/proc/self/exe");
  return Hash().bytes(bytes.data(), bytes.size()).value();
}

std::uint64_t fingerprint(const scenes::Stage& stage) {
  Hash hash;
  const scenes::Light& light = stage.light;
  for (const Vec3& v :
       {light.direction, light.color, light.sky, light.ground, light.rim, stage.background})
    add(hash, v);
  hash.number(light.scenery_casts);
  add(hash, stage.scenery);
  add(hash, stage.body_models);
  add(hash, stage.characters);
  for (const scenes::ConnectorLook& look : stage.connector_looks) {
    hash.number(look.kind).number(look.diameter);
    add(hash, look.color);
    hash.number(look.knob);
  }
  for (const scenes::Caption& caption : stage.captions)
    hash.number(caption.from).number(caption.until).text(caption.text).text(caption.list);
  for (const scenes::Trail& trail : stage.trails) {
    hash.number(trail.lasts).number(trail.width);
    add(hash, trail.color);
  }
  for (const scenes::Card& card : {stage.title, stage.end}) hash.text(card.heading).text(card.text);
  return hash.value();
}

std::uint64_t fingerprint(std::span<const draw::FrameState> shutter) {
  Hash hash;
  for (const draw::FrameState& instant : shutter) {
    hash.number(instant.state.time);
    for (const auto& particles : instant.state.connectors)
      for (const Vec3& p : particles) add(hash, p);
    for (const Pose& body : instant.state.bodies) add(hash, body);
    for (const auto& bones : instant.bones)
      for (const Pose& bone : bones) add(hash, bone);
    for (const scenes::TrailPoints& trail : instant.trails) {
      for (const double age : trail.ages) hash.number(age);
      for (const Vec3& place : trail.places) add(hash, place);
    }
    add(hash, instant.camera.position);
    add(hash, instant.camera.target);
    hash.number(instant.camera.field_of_view)
        .number(instant.camera.relative_aperture)
        .number(instant.camera.focus);
  }
  return hash.value();
}

namespace {

constexpr std::size_t kQueued = 2;

std::string bytes_of(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// True where a PNG file's bytes are of a picture of that size.
bool has_size(const std::string& png, const FrameFolder::Size& size) {
  constexpr std::size_t kWidth = 16, kHeight = 20;
  if (png.size() < kHeight + 4) return false;
  const auto number = [&](std::size_t at) {
    int value = 0;
    for (std::size_t k = 0; k < 4; ++k)
      value = (value << 8) | static_cast<unsigned char>(png[at + k]);
    return value;
  };
  return number(kWidth) == size.width && number(kHeight) == size.height;
}

bool is_frame(const std::filesystem::path& file) {
  const std::string stem = file.stem().string();
  return file.extension() == ".png" && stem.size() == 6 &&
         stem.find_first_not_of("0123456789") == std::string::npos;
}

}  // namespace

FrameFolder::FrameFolder(std::filesystem::path folder, bool keep, Size size, int writers)
    : folder_(std::move(folder)) {
  std::error_code error, unknown;
  std::filesystem::create_directories(folder_, error);
  if (!std::filesystem::is_directory(folder_, unknown))
    throw render::CannotWrite(
        fmt::format("{}: cannot be made a folder: {}", folder_.string(),
                    error ? error.message() : "a file of that name is in the way"));
  lock_ = render::Descriptor(open((folder_ / "lock").c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644));
  if (!lock_.is_open())
    throw render::CannotWrite(
        fmt::format("{}: {}", (folder_ / "lock").string(), std::strerror(errno)));
  if (!render::try_to_lock(lock_.get(), folder_))
    throw render::CannotWrite(
        fmt::format("{}: another run is writing frames here", folder_.string()));

  if (keep) kept_ = whole_frames(folder_, size);
  remove_others();
  render::AtomicFile journal(folder_ / "journal");
  for (const auto& [frame, entry] : kept_)
    journal.write(fmt::format("{:06} {:016x} {:016x}\n", frame, entry.inputs, entry.file));
  journal.commit();
  journal_ =
      render::Descriptor(open((folder_ / "journal").c_str(), O_WRONLY | O_APPEND | O_CLOEXEC));
  if (!journal_.is_open()) fail_journal();
  try {
    while (std::ssize(writers_) < writers)
      writers_.emplace_back([this](std::stop_token stop) { work(stop); });
  } catch (const std::system_error&) {  // no thread is to be had: put() writes
  }
}

FrameFolder::~FrameFolder() {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [&] { return (queue_.empty() && busy_ == 0) || failure_; });
}

/// Removes frames that are not to be kept, and what a run that was killed left half-written.
void FrameFolder::remove_others() {
  std::error_code error;
  std::vector<std::filesystem::path> others;
  for (std::filesystem::directory_iterator entry(folder_, error), end; !error && entry != end;
       entry.increment(error)) {
    const auto& file = entry->path();
    const bool half = file.extension() == ".part";
    if (is_frame(half ? file.stem() : file) &&
        (half || !kept_.contains(std::stoi(file.stem().string()))))
      others.push_back(file);
  }
  if (error == std::errc::not_enough_memory) throw std::bad_alloc();
  if (error) throw render::CannotWrite(fmt::format("{}: {}", folder_.string(), error.message()));
  for (const auto& file : others) render::remove_output(file);
}

std::filesystem::path FrameFolder::file(const std::filesystem::path& folder, int frame) {
  return folder / fmt::format("{:06}.png", frame);
}

FrameFolder::Entries FrameFolder::whole_frames(const std::filesystem::path& folder, Size size) {
  Entries entries;
  std::FILE* journal = std::fopen((folder / "journal").c_str(), "re");
  if (!journal) return entries;
  int frame = 0;
  unsigned long long inputs = 0, written = 0;
  // A line that a crash cut short ends the reading.
  while (std::fscanf(journal, "%d %16llx %16llx\n", &frame, &inputs, &written) == 3)
    entries[frame] = {inputs, written};
  std::fclose(journal);
  std::erase_if(entries, [&](const auto& entry) {
    const std::string png = bytes_of(file(folder, entry.first));
    return !has_size(png, size) ||
           Hash().bytes(png.data(), png.size()).value() != entry.second.file;
  });
  return entries;
}

bool FrameFolder::has(int frame, std::uint64_t inputs) const {
  const auto entry = kept_.find(frame);
  return entry != kept_.end() && entry->second.inputs == inputs;
}

void FrameFolder::put(int frame, std::uint64_t inputs, picture::Picture picture,
                      picture::PngExtras extras) {
  if (writers_.empty()) {
    return write({frame, inputs, std::move(picture), std::move(extras)});
  }
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [&] { return queue_.size() < kQueued || failure_; });
  if (failure_) std::rethrow_exception(failure_);
  queue_.push_back({frame, inputs, std::move(picture), std::move(extras)});
  changed_.notify_all();
}

void FrameFolder::finish() {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [&] { return (queue_.empty() && busy_ == 0) || failure_; });
  if (failure_) std::rethrow_exception(failure_);
}

void FrameFolder::work(std::stop_token stop) {
  std::unique_lock lock(mutex_);
  while (changed_.wait(lock, stop, [&] { return !queue_.empty() || failure_; }) && !failure_) {
    const Job job = std::move(queue_.front());
    queue_.pop_front();
    ++busy_;
    lock.unlock();
    std::exception_ptr failure;
    try {
      write(job);
    } catch (...) {
      failure = std::current_exception();
    }
    lock.lock();
    --busy_;
    if (failure && !failure_) failure_ = failure;
    changed_.notify_all();
  }
}

void FrameFolder::write(const Job& job) {
  const std::vector<std::uint8_t> bytes = picture::encode_png(job.picture, job.extras);
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  render::AtomicFile png(file(job.frame));
  png.write(text);
  png.commit();
  note(job.frame, {job.inputs, Hash().bytes(bytes.data(), bytes.size()).value()});
}

void FrameFolder::take(int frame, const Entry& entry, const std::filesystem::path& from) {
  std::filesystem::path half = file(frame);
  half += ".part";
  const render::UnfinishedFile unfinished(half);
  render::remove_output(half);
  std::error_code error;
  // Files of frames are replaced, never written to: two folders may share one.
  std::filesystem::create_hard_link(from, half, error);
  if (!error) std::filesystem::rename(half, file(frame), error);
  if (error) {  // another file system
    render::AtomicFile png(file(frame));
    png.write(bytes_of(from));
    png.commit();
  }
  kept_[frame] = entry;
  note(frame, entry);
}

void FrameFolder::note(int frame, const Entry& entry) {
  const std::string line = fmt::format("{:06} {:016x} {:016x}\n", frame, entry.inputs, entry.file);
  const std::lock_guard lock(mutex_);
  if (!render::write_all(journal_.get(), line)) fail_journal();
}

void FrameFolder::fail_journal() const {
  throw render::CannotWrite(fmt::format("{}: cannot be written: {}", (folder_ / "journal").string(),
                                        std::strerror(errno)));
}

}  // namespace taut::film
