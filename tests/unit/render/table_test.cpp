#include "render/chart/table.h"

#include <gtest/gtest.h>

#include <stdexcept>

namespace taut::table_test {
namespace {

chart::Table sample() {
  chart::Table table{{"method", "cost (ms)"}, {}};
  table.add({"springs, stiff", "12.5"});
  table.add({"a \"quoted\"\nname", "3"});
  return table;
}

TEST(Table, CsvComesBackAsItWas) {
  const chart::Table back = chart::from_csv(chart::to_csv(sample()));
  EXPECT_EQ(back.columns, sample().columns);
  EXPECT_EQ(back.rows, sample().rows);
}

TEST(Table, RefusesRowsThatDoNotFit) {
  EXPECT_THROW(sample().add({"one"}), std::invalid_argument);
  EXPECT_THROW(chart::from_csv("a,b\n1\n"), std::invalid_argument);
  EXPECT_THROW(chart::from_csv("a,b\n1,\"2"), std::invalid_argument);
  EXPECT_THROW(chart::from_csv(""), std::invalid_argument);
}

TEST(Table, TextAlignsNumbersToTheRight) {
  chart::Table table{{"n", "µs"}, {}};
  table.add({"one", "1"});
  table.add({"ten", "10.5"});
  EXPECT_EQ(chart::to_text(table), "n      µs\none     1\nten  10.5\n");
}

TEST(Table, MarkupEscapesItsOwnCharacters) {
  chart::Table table{{"a|b", "<x>"}, {}};
  table.add({"1 & 2", "\"q\""});
  EXPECT_EQ(chart::to_markdown(table), "| a\\|b | <x> |\n|---:|---|\n| 1 & 2 | \"q\" |\n");
  EXPECT_EQ(chart::to_html(table),
            "<table>\n<tr><th class=\"number\">a|b</th><th>&lt;x&gt;</th></tr>\n"
            "<tr><td class=\"number\">1 &amp; 2</td><td>&quot;q&quot;</td></tr>\n</table>\n");
}

TEST(Table, FitsIntoAWidth) {
  const chart::Table table{{"method", "a long heading", "another long heading"},
                           {{"impulse", "1", "2"}, {"direct", "3", "4"}}};
  EXPECT_EQ(chart::to_text(table, 100), chart::to_text(table));
  EXPECT_EQ(chart::to_text(table, 40),
            "method                impulse  direct\n"
            "a long heading              1       3\n"
            "another long heading        2       4\n");
  EXPECT_EQ(chart::to_text(table, 32),
            "method                impulse\n"
            "a long heading              1\n"
            "another long heading        2\n"
            "\n"
            "method                direct\n"
            "a long heading             3\n"
            "another long heading       4\n");
}

}  // namespace
}  // namespace taut::table_test
