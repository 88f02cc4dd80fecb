#include "render/cli/html_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>

#include "render/table.h"

namespace taut::cli {
namespace {

constexpr std::string_view kStyle = R"(
body { font: 15px/1.5 "DejaVu Sans", sans-serif; max-width: 1200px; margin: 2em auto; padding: 0 1em; }
svg { width: 100%; height: auto; }
table { border-collapse: collapse; font-size: 13px; display: block; overflow-x: auto; }
th, td { padding: 2px 10px; border-bottom: 1px solid #ddd; text-align: left; }
.number { text-align: right; font-variant-numeric: tabular-nums; }
)";

}  // namespace

std::string inline_svg(const Chart& chart) {
  const std::string svg = draw_chart(chart, ChartFormat::svg);
  return svg.substr(std::min(svg.size(), svg.find("<svg")));  // without the XML declaration
}

std::string html_page(const std::string& title, const std::string& body) {
  return fmt::format(
      "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>{0}</title>\n"
      "<style>{1}</style></head><body>\n<h1>{0}</h1>\n{2}</body></html>\n",
      escape_html(title), kStyle, body);
}

}  // namespace taut::cli
