#include "render/chart/chart.h"

#include <fmt/format.h>

#include <string_view>
#include <utility>
#include <vector>

#include "render/base/atomic_file.h"
#include "render/chart/gnuplot.h"
#include "render/chart/table.h"

namespace taut::chart {
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

namespace {

/// Gnuplot's own titles are numbers; readers of pages are told them when they point at a line.
std::string with_titles(const std::string& svg, const Chart& chart) {
  constexpr std::string_view kOpen = "<title>", kClose = "</title>", kOwn = "gnuplot_plot_";
  const std::vector<std::string> names = plot_names(chart);
  std::string out;
  std::size_t next = 0, done = 0;
  for (std::size_t at = 0; (at = svg.find(kOpen, done)) != std::string::npos;) {
    const std::size_t end = svg.find(kClose, at) + kClose.size();
    const std::string_view title = std::string_view(svg).substr(at + kOpen.size());
    out += svg.substr(done, at - done);
    const std::string name = !title.starts_with(kOwn) ? chart.title
                             : next < names.size()    ? names[next++]
                                                      : "";
    if (!name.empty()) out += fmt::format("{}{}{}", kOpen, escape_html(name), kClose);
    done = end;
  }
  return out + svg.substr(done);
}

}  // namespace

std::string draw_chart(const Chart& chart, ChartFormat format) {
  std::string drawn = run_gnuplot({"gnuplot", "-"}, gnuplot_script(chart, format)).output;
  return format == ChartFormat::svg ? with_titles(drawn, chart) : drawn;
}

void write_chart(const Chart& chart, const std::filesystem::path& base) {
  for (const auto& [format, ending] :
       {std::pair{ChartFormat::svg, ".svg"}, std::pair{ChartFormat::png, ".png"}}) {
    std::filesystem::path file = base;
    file += ending;
    render::AtomicFile out(file);
    out.write(draw_chart(chart, format));
    out.commit();
  }
}

}  // namespace taut::chart
