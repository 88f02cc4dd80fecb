// Captions and cards: when they show, and how bright they are.
#include "render/film/caption.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <utility>

namespace taut::caption_test {
namespace {

class CaptionTest : public testing::Test {
 protected:
  static picture::Picture filled(std::uint8_t value) {
    picture::Picture picture(320, 200);
    std::ranges::fill(picture.pixels, value);
    for (std::size_t i = 3; i < picture.pixels.size(); i += 4) picture.pixels[i] = 255;
    return picture;
  }
  /// The brightest red of a black picture with the captions.
  int brightest(const std::vector<scenes::Caption>& captions, const film::Playing& playing) {
    picture::Picture picture = filled(0);
    film::draw_captions(picture, font_, captions, playing);
    int most = 0;
    for (std::size_t i = 0; i < picture.pixels.size(); i += 4)
      most = std::max<int>(most, picture.pixels[i]);
    return most;
  }

  picture::Font font_{picture::Font::Weight::regular, picture::Font::Family::lato};
  const std::vector<scenes::Caption> one_ = {{1, 2, "HHH", ""}};
};

TEST_F(CaptionTest, ShowsBetweenItsTimes) {
  EXPECT_EQ(brightest(one_, {.time = 0.9}), 0);
  EXPECT_GT(brightest(one_, {.time = 1.5}), 200);
  EXPECT_GT(brightest(one_, {.time = 1.5}), brightest(one_, {.time = 1.95}));
  EXPECT_EQ(brightest(one_, {.time = 2.0}), 0);
}

TEST_F(CaptionTest, FadesWithTheClipAndNotAtACut) {
  // 0.1 s of the scene after it appears: two thirds of the fade, or four times that.
  const film::Playing slow{.time = 1.1, .rate = 0.25};
  EXPECT_LT(brightest(one_, {.time = 1.1}), brightest(one_, slow));
  EXPECT_EQ(brightest(one_, slow), brightest(one_, {.time = 1.5}));
  EXPECT_EQ(brightest(one_, {.time = 1.3, .from = 1.3}), brightest(one_, {.time = 1.5}));
  EXPECT_EQ(brightest(one_, {.time = 1.79, .until = 1.8}), brightest(one_, {.time = 1.5}));
}

TEST_F(CaptionTest, IsLeftOutWhereNobodyCouldReadIt) {
  EXPECT_EQ(brightest(one_, {.time = 1.85, .from = 1.7}), 0) << "0.3 s of it before a cut";
  EXPECT_EQ(brightest(one_, {.time = 1.5, .rate = 3}), 0) << "0.33 s of it, played fast";
  EXPECT_GT(brightest(one_, {.time = 1.85, .from = 1.7, .rate = 0.5}), 200) << "0.6 s of it";
}

TEST_F(CaptionTest, WhatFollowsATabBeginsInOneColumnThroughoutAList) {
  // Where the word, of one letter, begins.
  const auto begins = [&](const std::vector<scenes::Caption>& captions, double time) {
    picture::Picture picture = filled(0);
    film::draw_captions(picture, font_, captions, {.time = time});
    const int label_ends = int(0.05 * 320) + 10;
    for (int x = label_ends; x < picture.width; ++x)
      for (int y = 0; y < picture.height; ++y)
        if (picture.at(x, y)[0] > 60) return x;
    return -1;
  };
  const std::vector<scenes::Caption> list = {{1, 2, "i\tH", "phases"}, {2, 3, "w\tH", "phases"}},
                                     alone = {{1, 2, "i\tH", ""}, {2, 3, "w\tH", ""}};
  EXPECT_GT(begins(list, 1.5), 0);
  EXPECT_EQ(begins(list, 1.5), begins(list, 2.5));
  EXPECT_LT(begins(alone, 1.5), begins(alone, 2.5));
}

TEST_F(CaptionTest, NewlinesBreakTheLineAndCaptionsAtOneTimeAreStacked) {
  // The rows of the picture that have letters, as ranges from the bottom up.
  const auto bands = [&](const std::vector<scenes::Caption>& captions, double time) {
    picture::Picture picture = filled(0);
    film::draw_captions(picture, font_, captions, {.time = time});
    std::vector<std::pair<int, int>> found;
    bool before = false;
    for (int y = picture.height - 1; y >= 0; --y) {
      bool lit = false;
      for (int x = 0; x < picture.width; ++x) lit = lit || picture.at(x, y)[0] > 60;
      if (lit && !before) found.emplace_back(y, y);
      if (lit) found.back().second = y;
      before = lit;
    }
    return found;
  };
  const auto one = bands({{0, 9, "H", ""}}, 5), two = bands({{0, 9, "H\nH", ""}}, 5);
  ASSERT_EQ(one.size(), 1u);
  ASSERT_EQ(two.size(), 2u);
  EXPECT_EQ(two[0], one[0]) << "the last line is where a single one is";
  EXPECT_EQ(bands({{0, 9, "H\r\nH", ""}}, 5), two);
  EXPECT_EQ(bands({{0, 9, "H", ""}, {0, 9, "H", ""}}, 5), two) << "one above the other";
  EXPECT_EQ(bands({{0, 9, "H\nH", ""}, {1, 9, "H", ""}}, 5).size(), 3u);
  // The upper one stays where it is when the lower one goes, and the next takes its place.
  const std::vector<scenes::Caption> turns = {{0, 3, "H", ""}, {1, 9, "H", ""}, {3, 9, "H", ""}};
  EXPECT_EQ(bands(turns, 2), two);
  EXPECT_EQ(bands(turns, 5), two);
  EXPECT_EQ(bands({{0, 3, "H", ""}, {1, 9, "H", ""}}, 5), (std::vector{two[1]}));
  EXPECT_EQ(bands({{0, 3, "H", ""}, {3, 9, "H", ""}}, 5), one) << "one after the other";
}

TEST_F(CaptionTest, CharactersWithoutInkAreNotDrawnAndThoseWithoutAGlyphAreNamed) {
  EXPECT_EQ(font_.width("a\u200bb\u00adc\ufe0f", 20), font_.width("abc", 20));
  EXPECT_EQ(font_.missing("Gr\u00fc\u00dfe\n\t\u200b\u00ad\ufe0f"), std::vector<char32_t>());
  EXPECT_EQ(font_.missing("a\u53cc\u53ccb\u7bc0\x1b"),
            (std::vector<char32_t>{U'\u53cc', U'\u7bc0', U'\x1b'}));
  scenes::Stage stage;
  stage.captions = {{0, 1, "abc", ""}, {0, 1, "\u53cc", ""}};
  stage.end = {.duration = 1, .heading = "a", .text = "\u7bc0"};
  EXPECT_EQ(film::missing_glyphs(stage),
            (std::vector<std::string>{
                "caption 2: the font has no glyph for \"\u53cc\" (U+53CC)",
                "text of the end card: the font has no glyph for \"\u7bc0\" (U+7BC0)"}));
}

TEST_F(CaptionTest, IsReadOnWhiteAndDarkensNothingFartherThanALetter) {
  picture::Picture picture = filled(255);
  film::draw_captions(picture, font_, one_, {.time = 1.5});
  int left = picture.width, right = -1, top = picture.height, bottom = -1, darkest = 255;
  for (int y = 0; y < picture.height; ++y)
    for (int x = 0; x < picture.width; ++x) {
      const int value = picture.at(x, y)[0];
      darkest = std::min(darkest, value);
      if (value == 255) continue;
      left = std::min(left, x), right = std::max(right, x);
      top = std::min(top, y), bottom = std::max(bottom, y);
    }
  // 4.5:1 of luminances, as is asked of text: 1.05 above 0.183 and 0.05, which is 118 in sRGB.
  EXPECT_LT(darkest, 118);
  const double size = 9, base = 0.95 * picture.height - 0.3 * size, x = 0.05 * picture.width;
  EXPECT_GE(left, x - size);
  EXPECT_LE(right, x + font_.width("HHH", size) + size);
  EXPECT_GE(top, base - 2 * size);
  EXPECT_LE(bottom, base + size);
}

TEST_F(CaptionTest, ACardsLinesComeWhenThePictureIsDim) {
  picture::Font bold(picture::Font::Weight::bold);
  const scenes::Card card{.duration = 1, .heading = "HHH", .text = "one\ntwo"};
  const auto drawn = [&](double shown, std::uint8_t ground) {
    picture::Picture picture = filled(ground);
    film::draw_card(picture, font_, bold, card, "impulse", shown);
    return picture;
  };
  const auto range = [](const picture::Picture& picture) {
    int least = 255, most = 0;
    for (std::size_t i = 0; i < picture.pixels.size(); i += 4) {
      least = std::min<int>(least, picture.pixels[i]);
      most = std::max<int>(most, picture.pixels[i]);
    }
    return std::pair(least, most);
  };
  for (const double shown : {0.1, 0.3, 0.5}) {  // no line yet
    const auto [least, most] = range(drawn(shown, 255));
    EXPECT_EQ(least, most) << shown;
  }
  EXPECT_GT(range(drawn(0.3, 255)).first, range(drawn(0.5, 255)).first);
  constexpr int kDim = 255 * 18 / 100 + 1;  // of white, what a card leaves
  for (const double shown : {0.5, 0.7, 1.0}) {
    const picture::Picture on_white = drawn(shown, 255), on_black = drawn(shown, 0);
    EXPECT_GT(range(on_white).first, range(on_black).first) << shown;
    for (std::size_t i = 0; i < on_white.pixels.size(); ++i)
      ASSERT_LE(on_white.pixels[i] - on_black.pixels[i], kDim) << shown;
  }
  EXPECT_GT(range(drawn(1, 255)).second, 200);
  EXPECT_LT(range(drawn(1, 255)).first, 17 + kDim);
}

TEST_F(CaptionTest, ACardNamesTheMethod) {
  picture::Font bold(picture::Font::Weight::bold);
  picture::Picture named = filled(255), other = named;
  const scenes::Card by{.duration = 1, .heading = "H", .text = "by {method}"};
  film::draw_card(named, font_, bold, by, "direct", 1);
  film::draw_card(other, font_, bold, {.duration = 1, .heading = "H", .text = "by direct"}, "", 1);
  EXPECT_EQ(named.pixels, other.pixels);
}

}  // namespace
}  // namespace taut::caption_test
