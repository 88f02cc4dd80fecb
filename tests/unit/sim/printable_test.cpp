#include "sim/motion/printable.h"

#include <gtest/gtest.h>

#include "render/base/error.h"
#include "scenes/files/error.h"
#include "sim/run/method.h"

namespace taut::printable_test {
namespace {

using namespace std::string_literals;

TEST(Printable, KeepsText) {
  const std::string text = "Grüße, Привет, 双節棍, 🥋 \\x1b \"quoted\" 'and' %s {}";
  EXPECT_EQ(printable(text), text);
  EXPECT_EQ(printable(""), "");
}

TEST(Printable, EscapesWhatATerminalObeys) {
  EXPECT_EQ(printable("a\x1b[31mb\x7f\r\b"), "a\\x1b[31mb\\x7f\\x0d\\x08");
  EXPECT_EQ(printable("a\0b"s), "a\\x00b");
  EXPECT_EQ(printable("a\nb\tc"), "a\\nb\\tc");
  EXPECT_EQ(printable_lines("a\nb\tc\x1b"), "a\nb\\tc\\x1b");
  EXPECT_EQ(printable("\u009b31m"), "\\xc2\\x9b31m") << "C1";
  EXPECT_EQ(printable("\u202egnp.exe"), "\\xe2\\x80\\xaegnp.exe") << "turns the direction";
  EXPECT_EQ(printable("\u2028"), "\\xe2\\x80\\xa8") << "a line separator";
}

TEST(Printable, EscapesBytesThatAreNoText) {
  EXPECT_EQ(printable("\xff\xfe"), "\\xff\\xfe");
  EXPECT_EQ(printable("a\xc3"), "a\\xc3") << "cut short";
  EXPECT_EQ(printable("\xc0\x8a"), "\\xc0\\x8a") << "a newline in two bytes";
  EXPECT_EQ(printable("\xed\xa0\x80"), "\\xed\\xa0\\x80") << "half a pair";
  EXPECT_EQ(printable("\xf4\x90\x80\x80"), "\\xf4\\x90\\x80\\x80") << "beyond Unicode";
  EXPECT_EQ(printable("\xe2\x82x"), "\\xe2\\x82x");
}

TEST(Printable, MessagesOfErrorsAre) {
  const std::string name = "a\0\x1b\nb"s, shown = "a\\x00\\x1b\\nb";
  EXPECT_EQ(scenes::BadScene(name).what(), shown);
  EXPECT_EQ(scenes::BadAsset(name).what(), shown);
  EXPECT_EQ(render::CannotWrite(name).what(), shown);
  EXPECT_EQ(render::EncoderFailed("one\ntwo\x1b").what(), "one\ntwo\\x1b"s);
  EXPECT_NE(std::string(Diverged("direct", 0, 0, name, 0, "x").what()).find(shown),
            std::string::npos);
  EXPECT_EQ(Diverged("direct", 0, 0, name, 0, "x").connector, name);
}

}  // namespace
}  // namespace taut::printable_test
