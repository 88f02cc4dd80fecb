// Names as messages print them.
#include "scenes/files/printable.h"

#include <gtest/gtest.h>

namespace taut {
namespace {

using namespace std::string_literals;

TEST(Printable, WhatATerminalWouldObeyIsWrittenOut) {
  const auto expect = [](const std::string& text, const std::string& shown) {
    EXPECT_EQ(scenes::printable(text), shown);
    EXPECT_EQ(scenes::printable(shown), shown) << "twice is as once";
  };
  expect("", "");
  expect("a \"name\" \\ %s {}", "a \"name\" \\ %s {}");
  expect("\x1b[31mred", "\\x1b[31mred");
  expect("one\ntwo\ttabs\r", "one\\ntwo\\x09tabs\\x0d");
  expect("cut\0here"s, "cut\\x00here");
  expect("\x7f", "\\x7f");
  expect("\u0085\u009b", "\\xc2\\x85\\xc2\\x9b");
  expect("Gr\u00fc\u00dfe \u20ac \U0001f600 \u00a0", "Gr\u00fc\u00dfe \u20ac \U0001f600 \u00a0");
}

TEST(Printable, BytesThatAreNoUtf8AreWrittenOut) {
  EXPECT_EQ(scenes::printable("\xff"), "\\xff");
  EXPECT_EQ(scenes::printable("a\xc3"), "a\\xc3");
  EXPECT_EQ(scenes::printable("\xc3("), "\\xc3(");
  EXPECT_EQ(scenes::printable("\xc0\xaf"), "\\xc0\\xaf");  // longer than needed
  EXPECT_EQ(scenes::printable("\xe0\x80\xaf"), "\\xe0\\x80\\xaf");
  EXPECT_EQ(scenes::printable("\xed\xa0\x80"), "\\xed\\xa0\\x80");  // half of a pair
  EXPECT_EQ(scenes::printable("\xf4\x90\x80\x80"), "\\xf4\\x90\\x80\\x80");
}

}  // namespace
}  // namespace taut
