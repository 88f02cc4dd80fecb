#include "render/chart.h"

#include <fmt/format.h>

#include <system_error>

#include "render/atomic_file.h"
#include "render/child.h"
#include "render/error.h"

namespace taut {
namespace {

// Okabe and Ito's colours, which stay apart for colour-blind readers, without the yellow that
// vanishes on white; dash and marker carry the difference into grey print.
constexpr Style kMethodStyles[] = {
    {0xd55e00, 0, 0},  // vermilion
    {0x0072b2, 1, 1},  // blue
    {0x56b4e9, 2, 2},  // sky
    {0x009e73, 3, 3},  // green
    {0xe69f00, 4, 4},  // orange
    {0xcc79a7, 5, 5},  // purple
    {0x000000, 0, 6},  // black
    {0x8c6d31, 1, 7},  // brown
    // Of Tol's colours, for engines beside them.
    {0x882255, 2, 0},  // wine
    {0x332288, 3, 1},  // indigo
    {0x999933, 5, 2},  // olive
};

}  // namespace

Style method_style(std::size_t index) {
  return kMethodStyles[index % std::size(kMethodStyles)];
}

Style truth_style() {
  return {0x777777, 0, 8};
}

std::string draw_chart(const Chart& chart, ChartFormat format) {
  ChildResult result;
  try {
    result = run_child({"gnuplot", "-"}, gnuplot_script(chart, format));
  } catch (const std::system_error& error) {
    throw CannotWrite(
        fmt::format("{}; charts are drawn by gnuplot (Debian: gnuplot-nox)", error.what()));
  }
  if (result.status != 0 || result.output.empty()) {
    throw CannotWrite(
        fmt::format("gnuplot failed with status {}: {}", result.status, result.errors));
  }
  return std::move(result.output);
}

void write_chart(const Chart& chart, const std::filesystem::path& base) {
  for (const auto& [format, ending] :
       {std::pair{ChartFormat::svg, ".svg"}, std::pair{ChartFormat::png, ".png"}}) {
    std::filesystem::path file = base;
    file += ending;
    AtomicFile out(file);
    out.write(draw_chart(chart, format));
    out.commit();
  }
}

}  // namespace taut
