// taut render when the world fails it: killed, interrupted, out of room, without a driver. Frames
// already made stay, nothing half-written has a final name, and --resume goes on.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <csignal>
#include <fstream>
#include <functional>
#include <map>
#include <random>
#include <regex>
#include <thread>

#include "render/picture/picture.h"
#include "tests/cli/swing_scene.h"
#include "tests/support/fault_table.h"
#include "tests/support/folder.h"
#include "tests/support/program.h"

namespace taut {
namespace {

namespace fs = std::filesystem;

const std::string kLongSwing = swing_scene(6.0);
constexpr int kFrames = 300;

class RenderFaults : public testing::Test {
 protected:
  std::vector<std::string> command(std::vector<std::string> more = {}) const {
    more.insert(more.begin(),
                {TAUT_PROGRAM, "render", scene_.string(), "--out", out_.string(), "--quiet"});
    return more;
  }
  ProgramResult render(std::vector<std::string> more = {},
                       const std::function<void()>& prepare = {}) const {
    return Child(command(std::move(more)), folder_.path(), prepare).wait();
  }
  /// A render of a few frames that says what it finds of an earlier one.
  ProgramResult again(const std::string& program, std::vector<std::string> more = {}) const {
    more.insert(more.begin(), {program, "render", scene_.string(), "--out", out_.string(),
                               "--frames", "0-4", "--no-video"});
    return Child(std::move(more), folder_.path()).wait();
  }
  fs::path frames() const { return out_ / "frames"; }

  /// Waits until some frames are there.
  void wait_for_frames(std::size_t count) const {
    ASSERT_TRUE(comes_true([&] { return finished().size() >= count; }));
  }

  /// Every finished frame by its name. Files with a final name must be whole.
  std::map<std::string, picture::Picture> finished() const {
    std::map<std::string, picture::Picture> pictures;
    if (!fs::exists(frames())) return pictures;
    for (const auto& entry : fs::directory_iterator(frames()))
      if (entry.path().extension() == ".png")
        pictures.emplace(entry.path().filename(), picture::read_png(entry.path()));
    return pictures;
  }

  /// Every file of the clip that must not depend on what happened on the way.
  std::map<std::string, std::string> clip() const {
    std::map<std::string, std::string> files = {{"video", read_file(out_ / "swing.mp4")}};
    for (const auto& entry : fs::directory_iterator(frames()))
      if (entry.path().extension() == ".png")
        files.emplace(entry.path().filename(), read_file(entry.path()));
    return files;
  }

  void kill_and_resume(int kills) {
    ASSERT_EQ(render().code, 0);
    const auto undisturbed = clip();
    ASSERT_EQ(undisturbed.size(), kFrames + 1);
    fs::remove_all(out_);
    std::mt19937 chance(1);
    for (int i = 0; i < kills; ++i) {
      Child child(command({"--resume"}), folder_.path());
      // A whole run takes seconds: any moment of it, and of the encoding at its end.
      std::this_thread::sleep_for(std::chrono::milliseconds(chance() % 1500));
      kill(child.id(), SIGKILL);
      child.wait();
      finished();
      if (fs::exists(out_ / "swing.mp4")) {
        EXPECT_EQ(read_file(out_ / "swing.mp4"), undisturbed.at("video"));
        fs::remove_all(out_);
      }
    }
    ASSERT_EQ(render({"--resume"}).code, 0);
    EXPECT_TRUE(clip() == undisturbed);
  }

  Folder folder_;
  fs::path scene_ = folder_.write("swing.toml", kLongSwing);
  fs::path out_ = folder_.path() / "clip";
};

TEST_F(RenderFaults, KilledAtAnyMomentItGoesOn) {
  kill_and_resume(5);
}

using LongRenderFaults = RenderFaults;

TEST_F(LongRenderFaults, KilledAtTwoHundredMomentsItGoesOn) {
  kill_and_resume(200);
}

TEST_F(RenderFaults, SignalsEndItInOrder) {
  for (const auto& [signal, code] : {std::pair(SIGINT, 130), {SIGTERM, 143}}) {
    fs::remove_all(out_);
    Child child(command(), folder_.path());
    wait_for_frames(5);
    kill(child.id(), signal);
    EXPECT_EQ(child.wait().code, code);
    EXPECT_GE(finished().size(), 5u) << "frames already made stay";
    EXPECT_FALSE(fs::exists(out_ / "swing.mp4"));
    for (const auto& entry : fs::recursive_directory_iterator(out_))
      EXPECT_NE(entry.path().extension(), ".part") << entry.path();
  }
}

TEST_F(RenderFaults, TwoRunsDoNotShareAFolder) {
  Child first(command(), folder_.path());
  wait_for_frames(1);
  kill(first.id(), SIGSTOP);  // so that it has not ended when the second comes
  const ProgramResult second = render();
  EXPECT_EQ(second.code, 6);
  EXPECT_NE(second.messages.find("another run is writing frames here"), std::string::npos)
      << second.messages;
}

TEST_F(RenderFaults, AFileSizeLimitKeepsTheFramesSoFar) {
  ASSERT_EQ(render({"--frames", "0-4", "--no-video"}).code, 0);
  const ProgramResult outcome = render({"--resume", "--no-video"}, [] {
    const rlimit limit{1000, 1000};
    setrlimit(RLIMIT_FSIZE, &limit);
  });
  EXPECT_EQ(outcome.code, 6);
  EXPECT_NE(outcome.messages.find("File too large"), std::string::npos) << outcome.messages;
  EXPECT_EQ(finished().size(), 5u);
}

TEST_F(RenderFaults, NoContextIsFour) {
  const ProgramResult outcome =
      render({"--backend", "egl"}, [] { setenv("__EGL_VENDOR_LIBRARY_DIRS", "/nonexistent", 1); });
  EXPECT_EQ(outcome.code, 4);
  EXPECT_NE(outcome.messages.find("EGL surfaceless"), std::string::npos) << outcome.messages;
  EXPECT_FALSE(fs::exists(out_));
}

TEST_F(RenderFaults, AChangedSceneIsDrawnAnew) {
  ASSERT_EQ(render({"--frames", "100", "--no-video"}).code, 0);
  const auto before = finished();
  std::string text = kLongSwing;
  text.replace(text.find("mass = 0.12"), 11, "mass = 0.02");
  folder_.write("swing.toml", text);
  ASSERT_EQ(render({"--frames", "100", "--no-video", "--resume"}).code, 0);
  EXPECT_NE(finished().at("000100.png").pixels, before.at("000100.png").pixels);
}

TEST_F(RenderFaults, FramesOfAnEarlierRunStayWhereTheyAreTheSame) {
  FaultTable table("Output that exists", folder_.path());
  const auto expect = [&](const char* fault, const ProgramResult& outcome, const char* says) {
    EXPECT_EQ(outcome.code, 0) << fault << ": " << outcome.messages;
    EXPECT_NE(outcome.messages.find(says), std::string::npos) << fault << ": " << outcome.messages;
    table.add(fault, outcome);
  };
  const char* const kAll = "5 of 5 frames were there already";
  const char* const kNone = "0 of 5 frames were there already; 5 were made from another";
  const char* const kNothingKept =
      "error estimate: none, as impulse does not converge to the exact solution, whatever its "
      "step\n";
  EXPECT_EQ(again(TAUT_PROGRAM).messages, kNothingKept);
  expect("the same clip", again(TAUT_PROGRAM), kAll);
  expect("the same clip, resumed", again(TAUT_PROGRAM, {"--resume"}), kAll);
  fs::resize_file(out_ / "frames/000002.png", 100);
  expect("a frame cut short", again(TAUT_PROGRAM, {"--resume"}), "4 of 5 frames");
  // A copy that differs in a byte that is never run.
  const fs::path changed = folder_.path() / "taut";
  fs::copy_file(TAUT_PROGRAM, changed);
  std::ofstream(changed, std::ios::app) << '\0';
  expect("another program", again(changed, {"--resume"}), kNone);
  expect("another driver", again(changed, {"--resume", "--backend", "osmesa"}), kNone);
  std::string text = kLongSwing;
  text.replace(text.find("length = 0.30"), 13, "length = 0.25");
  folder_.write("swing.toml", text);
  expect("another scene", again(changed, {"--resume", "--backend", "osmesa"}), kNone);
  EXPECT_EQ(again(changed, {"--anew"}).messages, kNothingKept);
  EXPECT_TRUE(table.is_as_accepted());
}

/// A stand-in for ffmpeg that answers when it is asked whether it is there.
class FakeFfmpeg {
 public:
  FakeFfmpeg(const Folder& folder, const std::string& script,
             const std::string& when_asked = "exit 0") {
    const fs::path program =
        folder.write("bin/ffmpeg", "#!/bin/sh\ncase \"$*\" in *-version*) " + when_asked +
                                       ";; esac\n" + script + "\n");
    fs::permissions(program, fs::perms::owner_all);
    path_ = program.parent_path().string() + ":/usr/bin:/bin";
  }
  void operator()() const { setenv("PATH", path_.c_str(), 1); }

 private:
  std::string path_;
};

TEST_F(RenderFaults, WhatAKilledRunLeavesAliveTouchesNoVideoOfALaterOne) {
  const std::vector<std::string> few = {"--frames", "0-4"};
  // The encoder opens its output and lives on, as one that the kernel does not end would.
  const FakeFfmpeg slow(
      folder_,
      "for last; do :; done; last=${last#file:}\ncd " + folder_.path().string() +
          "\n(exec 3>>\"$last\"; echo > opened; while [ ! -e go ]; do sleep "
          "0.05; done; echo broken >&3; echo broken > \"$last\"; echo > done) "
          "</dev/null >/dev/null 2>&1 &\necho $$ > encoder.part; mv encoder.part encoder\nwait");
  Child killed(command(few), folder_.path(), slow);
  const auto exists = [&](const char* name) { return fs::exists(folder_.path() / name); };
  ASSERT_TRUE(comes_true([&] { return exists("opened") && exists("encoder"); }));
  kill(killed.id(), SIGKILL);
  killed.wait();
  const pid_t encoder = std::stoi(read_file(folder_.path() / "encoder"));
  // Whoever takes over a process that has ended may leave it unburied.
  EXPECT_TRUE(comes_true([&] {
    const std::string status = read_file(fmt::format("/proc/{}/stat", encoder));
    return status.empty() || status.find(") Z") != std::string::npos;
  })) << "it outlives its parent";

  ASSERT_EQ(render(few).code, 0);
  const std::string video = read_file(out_ / "swing.mp4");
  folder_.write("go", "");
  ASSERT_TRUE(comes_true([&] { return exists("done"); }));
  EXPECT_EQ(read_file(out_ / "swing.mp4"), video);
  std::ofstream(frames() / "000299.png.part") << "half";
  ASSERT_EQ(render(few).code, 0);
  for (const auto& entry : fs::recursive_directory_iterator(out_))
    EXPECT_NE(entry.path().extension(), ".part") << entry.path();
}

TEST_F(RenderFaults, AFullDiskIsSixWhileFfmpegWritesToo) {
  const std::vector<std::string> few = {"--frames", "0-4"};
  const auto expect_full = [&](const ProgramResult& outcome, const char* cause) {
    EXPECT_EQ(outcome.code, 6) << outcome.messages;
    EXPECT_NE(outcome.messages.find(cause), std::string::npos) << outcome.messages;
    for (const auto& entry : fs::recursive_directory_iterator(out_))
      EXPECT_NE(entry.path().extension(), ".part") << entry.path();
  };
  expect_full(render(few, FakeFfmpeg(folder_, "echo 'x.mp4: No space left on device' >&2; exit 1")),
              "swing.mp4: cannot be written: No space left on device");
  // The frames are there; each video is larger than a file may be, whatever FFmpeg says of it.
  for (const char* name : {"swing.mp4", "swing.gif", "swing.webm", "swing.webp"}) {
    std::vector<std::string> options = few;
    options.insert(options.end(), {"-o", (out_ / name).string()});
    ASSERT_EQ(render(options).code, 0) << name;
    const rlim_t size = fs::file_size(out_ / name);
    fs::remove(out_ / name);
    const ProgramResult outcome = render(options, [size] {
      const rlimit limit{size / 2, size / 2};
      setrlimit(RLIMIT_FSIZE, &limit);
    });
    expect_full(outcome, "File too large");
    EXPECT_FALSE(fs::exists(out_ / name)) << name;
  }
}

TEST_F(RenderFaults, FfmpegGetsNamesAsNames) {
  const std::vector<std::string> few = {"--frames", "0-4", "-o"};
  out_ = folder_.path() / "a\nfile 'x'\n #";
  for (const char* name : {"-y.mp4", "concat:a.mp4", "pipe:1.mp4", "a b'c\\d\"e%03d.webm",
                           "new\nline.gif", "file:x.mov", "a|b.webp"}) {
    std::vector<std::string> options = few;
    options.back() = std::string("--output=") + name;
    Child child(command(options), folder_.path());
    const ProgramResult outcome = child.wait();
    EXPECT_EQ(outcome.code, 0) << name << ": " << outcome.messages;
    const fs::path file = folder_.path() / name;
    ASSERT_TRUE(fs::exists(file)) << name;
    EXPECT_GT(fs::file_size(file), 0u) << name;
  }
}

TEST_F(RenderFaults, PatienceHoldsForEachOfFfmpegsCalls) {
  // FFmpeg's default patience is longer than this answer takes.
  const ProgramResult outcome = render({"--frames", "0-4", "--patience", "0.5"},
                                       FakeFfmpeg(folder_, "exit 0", "exec sleep 30"));
  EXPECT_EQ(outcome.code, 5);
  EXPECT_NE(outcome.messages.find("did nothing for too long"), std::string::npos)
      << outcome.messages;
}

TEST_F(RenderFaults, FfmpegsWordsAreTold) {
  const ProgramResult outcome =
      render({"--frames", "0-4"},
             FakeFfmpeg(folder_, R"(printf 'one\ntwo \033[31m\200\007 end' >&2; exit 1)"));
  EXPECT_EQ(outcome.code, 5);
  EXPECT_NE(outcome.messages.find("one\ntwo \\x1b[31m\\x80\\x07 end"), std::string::npos)
      << outcome.messages;
}

TEST_F(RenderFaults, EveryFaultIsNamed) {
  FaultTable table("Renders", folder_.path());
  const auto expect = [&](const char* fault, int code, const std::vector<std::string>& options,
                          const std::function<void()>& prepare = {}) {
    const ProgramResult outcome = render(options, prepare);
    EXPECT_EQ(outcome.code, code) << fault << ": " << outcome.messages;
    EXPECT_EQ(outcome.output, "") << fault;
    table.add(fault, outcome);
  };
  expect("odd size of a video", 2, {"--size", "63x36"});
  expect("size beyond the driver", 4, {"--size", "100000x2", "--no-video"});
  expect("no such frame", 2, {"--frames", "8-1200"});
  expect("frames backwards", 2, {"--frames", "3-1"});
  expect("zero frames", 2, {"--frames", ""});
  expect("simulation diverging", 7,
         {"--method", "springs", "--step", "0.02", "--set", "stiffness=1e9"});
  expect("no rendering context", 4, {"--backend", "egl"},
         [] { setenv("__EGL_VENDOR_LIBRARY_DIRS", "/nonexistent", 1); });
  expect("FFmpeg missing", 5, {}, [] { setenv("PATH", "/nonexistent", 1); });
  const std::vector<std::string> few = {"--frames", "0-4"};
  expect("FFmpeg fails", 5, few, FakeFfmpeg(folder_, "echo no such codec >&2; exit 1"));
  expect("FFmpeg is killed", 5, few, FakeFfmpeg(folder_, "kill -9 $$"));
  expect("FFmpeg makes nothing, and says that all is well", 5, few, FakeFfmpeg(folder_, "exit 0"));
  expect("FFmpeg makes too few frames", 5, few,
         FakeFfmpeg(folder_,
                    "for last; do :; done; /usr/bin/ffmpeg -v error -f lavfi -i "
                    "color=s=64x36:r=50:d=0.04 -y -f mp4 $last"));
  std::vector<std::string> impatient = few;
  impatient.insert(impatient.end(), {"--patience", "0.5"});
  expect("FFmpeg is blocked", 5, impatient, FakeFfmpeg(folder_, "exec sleep 1000"));
  for (const auto& [fault, signal] :
       {std::pair("Ctrl-C", SIGINT), {"SIGTERM", SIGTERM}, {"kill -9", SIGKILL}}) {
    fs::remove_all(out_);
    Child child(command(), folder_.path());
    wait_for_frames(1);
    kill(child.id(), signal);
    ProgramResult outcome = child.wait();
    EXPECT_EQ(outcome.code, 128 + signal);
    outcome.messages = std::regex_replace(outcome.messages, std::regex("[0-9]+ of"), "N of");
    table.add(fault, outcome);
  }
  {
    fs::remove_all(out_);
    Child first(command(), folder_.path());
    wait_for_frames(1);
    expect("two runs into one folder", 6, {});
  }
  expect("file size limit", 6, {"--no-video", "--anew", "--threads", "1"}, [] {
    const rlimit limit{1000, 1000};
    setrlimit(RLIMIT_FSIZE, &limit);
  });
  const fs::path out = std::exchange(out_, folder_.write("file", "x") / "clip");
  expect("output under a file", 6, {});
  out_ = out;
  expect("a poster after the clip's end", 2, {"--poster", "99"});
  expect("a kind of file that nobody knows", 2, {"-o", "clip.avi"});
  expect("opacity where there is none", 2, {"-o", "clip.mp4", "--transparent"});
  EXPECT_TRUE(table.is_as_accepted());
}

}  // namespace
}  // namespace taut
