// Captions and cards: when they show, and how bright they are.
#include "render/film/caption.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "render/film/card.h"

namespace taut {
namespace {

class CaptionTest : public testing::Test {
 protected:
  /// The brightest red in rows of the picture that the captions leave at `time`, from its height.
  int brightest(const std::vector<scenes::Caption>& captions, double time, double above,
                double below) {
    picture::Picture picture(320, 200);
    std::ranges::fill(picture.pixels, std::uint8_t{0});
    film::draw_captions(picture, font_, captions, time);
    int most = 0;
    for (int y = int(above * picture.height); y < int(below * picture.height); ++y)
      for (int x = 0; x < picture.width; ++x) most = std::max<int>(most, picture.at(x, y)[0]);
    return most;
  }

  picture::Font font_{picture::Font::Weight::regular, picture::Font::Family::lato};
  const std::vector<scenes::Caption> list_ = {{1, 2, "HHH", "phases"}, {2, 3, "HHH", "phases"}};
};

TEST_F(CaptionTest, ShowsBetweenItsTimes) {
  const std::vector<scenes::Caption> one = {{1, 2, "HHH", ""}};
  EXPECT_EQ(brightest(one, 0.9, 0, 1), 0);
  EXPECT_GT(brightest(one, 1.5, 0, 1), 200);
  EXPECT_GT(brightest(one, 1.5, 0, 1), brightest(one, 1.95, 0, 1));
  EXPECT_EQ(brightest(one, 2.0, 0, 1), 0);
}

TEST_F(CaptionTest, TheLineWhoseTimeItIsStandsInTheMiddleAndItsNeighboursFainter) {
  const double above = 0.835, below = 0.885;  // the middle line is between them
  for (const bool first : {true, false}) {
    const double time = first ? 1.5 : 2.5;
    const int middle = brightest(list_, time, above, below);
    const int next = brightest(list_, time, below, 1), before = brightest(list_, time, 0, above);
    EXPECT_GT(middle, 200);
    EXPECT_GT(first ? next : before, 80);
    EXPECT_LT(first ? before : next, 10);
    EXPECT_GT(middle - std::max(next, before), 50);
  }
  const std::vector<scenes::Caption> three = {
      {1, 2, "HHH", "phases"}, {2, 3, "HHH", "phases"}, {3, 4, "HHH", "phases"}};
  EXPECT_LT(brightest(three, 1.5, 0.96, 1), 10) << "the next but one";
  EXPECT_EQ(brightest(list_, 0.9, 0, 1), 0);
  EXPECT_GT(brightest(list_, 2.99, above, below), 200) << "the last line is read to the end";
  EXPECT_EQ(brightest(list_, 3.3, 0, 1), 0);
}

TEST_F(CaptionTest, WhatFollowsATabBeginsInOneColumn) {
  // The first column of pixels that the word, of one letter, lights in each line.
  const auto begins = [&](const std::vector<scenes::Caption>& captions, double above,
                          double below) {
    picture::Picture picture(320, 200);
    std::ranges::fill(picture.pixels, std::uint8_t{0});
    film::draw_captions(picture, font_, captions, 1.5);
    const int label_ends = int(0.05 * 320) + 12;
    for (int x = label_ends; x < picture.width; ++x)
      for (int y = int(above * picture.height); y < int(below * picture.height); ++y)
        if (picture.at(x, y)[0] > 60) return x;
    return -1;
  };
  const std::vector<scenes::Caption> list = {{1, 2, "i\tH", "phases"}, {2, 3, "w\tH", "phases"}};
  const int upper = begins(list, 0.835, 0.885), lower = begins(list, 0.885, 1);
  EXPECT_GT(upper, 0);
  EXPECT_EQ(upper, lower);
}

TEST_F(CaptionTest, ACardDarkensThePictureBehindItsLines) {
  picture::Font bold(picture::Font::Weight::bold);
  const scenes::Card card{.duration = 1, .heading = "HHH", .text = "one\ntwo"};
  picture::Picture picture(320, 200), half = picture, named = picture, other = picture;  // white
  film::draw_card(picture, font_, bold, card, "impulse", 1);
  film::draw_card(half, font_, bold, card, "impulse", 0.5);
  EXPECT_LT(picture.at(5, 5)[0], 255 / 2);
  EXPECT_GT(half.at(5, 5)[0], picture.at(5, 5)[0]);
  EXPECT_LT(half.at(5, 5)[0], 255);
  int brightest = 0;
  for (int x = 0; x < 320; ++x) brightest = std::max<int>(brightest, picture.at(x, 85)[0]);
  EXPECT_GT(brightest, 200);
  const scenes::Card by{.duration = 1, .heading = "H", .text = "by {method}"};
  film::draw_card(named, font_, bold, by, "direct", 1);
  film::draw_card(other, font_, bold, {.duration = 1, .heading = "H", .text = "by direct"}, "", 1);
  EXPECT_EQ(named.pixels, other.pixels);
}

}  // namespace
}  // namespace taut
