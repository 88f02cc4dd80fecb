// A folder of numbered frames, written while the next frame is drawn, and the journal that tells
// which of them can be kept.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <exception>
#include <filesystem>
#include <map>
#include <mutex>
#include <span>
#include <thread>
#include <vector>

#include "render/base/atomic_file.h"
#include "render/draw/view.h"
#include "render/picture/picture.h"
#include "scenes/scene/stage.h"

namespace taut::film {

// Hashes of everything that a frame is made from, by which finished frames are known again.

/// Of the program itself (its executable file).
std::uint64_t program_fingerprint();
/// Of what never moves: models, lights, looks, captions.
std::uint64_t fingerprint(const scenes::Stage& stage);
/// Of what moves while the shutter is open, bit for bit.
std::uint64_t fingerprint(std::span<const draw::FrameState> shutter);

/// Frames are NNNNNN.png. The journal has a line per frame: its number, the hash of everything it
/// was made from, and that of its file; a frame is kept only where both still hold.
class FrameFolder {
 public:
  /// The size that the frames of a run share.
  struct Size {
    int width = 0, height = 0;
  };
  /// Hashes of what a frame was made from and of its file.
  struct Entry {
    std::uint64_t inputs, file;
  };
  using Entries = std::map<int, Entry>;

  /// The frames of that size in a folder that are whole, by number. Other runs may be writing
  /// there.
  static Entries whole_frames(const std::filesystem::path& folder, Size size);

  /// Makes the folder. Frames of that size that another run left stay where their journal stands
  /// and `keep` is set, and are removed otherwise. `writers`: threads that write, where so many
  /// can be had. Throws CannotWrite, also while another run writes here.
  FrameFolder(std::filesystem::path folder, bool keep, Size size, int writers = 1);
  /// Waits until the frames given so far are written.
  ~FrameFolder();
  FrameFolder(const FrameFolder&) = delete;
  FrameFolder& operator=(const FrameFolder&) = delete;

  std::filesystem::path file(int frame) const { return file(folder_, frame); }
  static std::filesystem::path file(const std::filesystem::path& folder, int frame);
  /// True where a whole frame of this number is there, whatever it was made from.
  bool knows(int frame) const { return kept_.contains(frame); }
  /// True where a frame made from these inputs is there, whole.
  bool has(int frame, std::uint64_t inputs) const;
  /// Writes the frame, on another thread where there can be one; waits while two others wait, too.
  /// Throws CannotWrite where an earlier frame could not be written.
  void put(int frame, std::uint64_t inputs, picture::Picture picture,
           picture::PngExtras extras = {});
  /// Waits for all frames. Throws CannotWrite.
  void finish();
  /// Takes a frame of another folder, which keeps it; not while frames are on their way. Throws
  /// CannotWrite.
  void take(int frame, const Entry& entry, const std::filesystem::path& from);

 private:
  struct Job {
    int frame;
    std::uint64_t inputs;
    picture::Picture picture;
    picture::PngExtras extras;
  };
  void remove_others();
  void work(std::stop_token stop);
  void write(const Job& job);
  void note(int frame, const Entry& entry);
  [[noreturn]] void fail_journal() const;

  std::filesystem::path folder_;
  render::Descriptor lock_, journal_;
  Entries kept_;

  std::mutex mutex_;
  std::condition_variable_any changed_;
  std::deque<Job> queue_;
  int busy_ = 0;  // writers that write
  std::exception_ptr failure_;
  std::vector<std::jthread> writers_;  // last: they use everything above
};

}  // namespace taut::film
