// Frames on their way to the disk while the next ones come.
#include "render/film/frame_folder.h"

#include <gtest/gtest.h>

#include <memory>

#include "render/base/error.h"
#include "tests/support/folder.h"

namespace taut::frame_folder_test {
namespace {

constexpr int kFrames = 40;
constexpr film::FrameFolder::Size kSize{64, 48};

picture::Picture picture(int frame) {
  picture::Picture made(64, 48);
  for (std::size_t i = 0; i < made.pixels.size(); ++i)
    if (i % 4 != 3)
      made.pixels[i] = static_cast<std::uint8_t>(i * static_cast<std::size_t>(frame + 1));
  return made;
}

void fill(film::FrameFolder& frames) {
  for (int k = 0; k < kFrames; ++k) frames.put(k, static_cast<std::uint64_t>(k), picture(k));
}

TEST(FrameFolder, WritesEveryFrameAndKnowsItAgain) {
  for (const int writers : {0, 1, 4}) {
    const Folder folder;
    {
      film::FrameFolder frames(folder.path() / "frames", true, kSize, writers);
      fill(frames);
      frames.finish();
    }
    const film::FrameFolder again(folder.path() / "frames", true, kSize);
    for (int k = 0; k < kFrames; ++k) {
      EXPECT_TRUE(again.has(k, static_cast<std::uint64_t>(k))) << writers;
      EXPECT_FALSE(again.has(k, 1000));
      EXPECT_EQ(picture::read_png(again.file(k)).pixels, picture(k).pixels);
    }
  }
}

TEST(FrameFolder, HasFramesOfOneSizeAlone) {
  const Folder folder;
  { fill(*std::make_unique<film::FrameFolder>(folder.path(), true, kSize)); }
  const film::FrameFolder larger(folder.path(), true, film::FrameFolder::Size{128, 96});
  for (int k = 0; k < kFrames; ++k) {
    EXPECT_FALSE(larger.knows(k));
    EXPECT_FALSE(std::filesystem::exists(larger.file(k)));
  }
}

TEST(FrameFolder, WritesWhatItWasGivenBeforeItGoes) {
  const Folder folder;
  { fill(*std::make_unique<film::FrameFolder>(folder.path(), true, kSize)); }
  const film::FrameFolder again(folder.path(), true, kSize);
  for (int k = 0; k < kFrames; ++k) EXPECT_TRUE(again.knows(k));
}

TEST(FrameFolder, IsOneRunsAlone) {
  const Folder folder;
  const film::FrameFolder first(folder.path(), true, kSize);
  EXPECT_THROW(film::FrameFolder(folder.path(), true, kSize), render::CannotWrite);
}

TEST(FrameFolder, SaysThatAFrameCouldNotBeWritten) {
  const Folder folder;
  film::FrameFolder frames(folder.path(), true, kSize);
  folder.write("000003.png/in the way", "");
  EXPECT_THROW(
      {
        fill(frames);
        frames.finish();
      },
      render::CannotWrite);
}

}  // namespace
}  // namespace taut::frame_folder_test
