#include "render/chart/html_page.h"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <string_view>

#include "render/chart/chart_layout.h"
#include "render/chart/page_script.h"
#include "render/chart/table.h"

namespace taut::chart {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::string_view kStyle = R"(
:root { color-scheme: light; --paper: #fff; --ink: #1b1b1b; --faint: #5c5c5c; --line: #ddd; --tint: #f3f4f6; --mark: #b00020; }
:root[data-theme=dark] { color-scheme: dark; --paper: #16181b; --ink: #e6e6e6; --faint: #a8adb3; --line: #3a3f45; --tint: #22262b; --mark: #ff8a80; }
@media (prefers-color-scheme: dark) { :root:not([data-theme=light]) { color-scheme: dark; --paper: #16181b; --ink: #e6e6e6; --faint: #a8adb3; --line: #3a3f45; --tint: #22262b; --mark: #ff8a80; } }
html { font-size: clamp(15px, 9px + 0.45vw, 30px); }
body { font: 1rem/1.5 "DejaVu Sans", system-ui, sans-serif; margin: 0 auto; padding: 1rem min(4vw, 4rem); max-width: 110rem; background: var(--paper); color: var(--ink); overflow-wrap: anywhere; }
h1, h2, h3 { line-height: 1.25; margin: 1.6em 0 0.5em; } h1 { font-size: 1.6rem; margin-top: 0.4em; } h2 { font-size: 1.3rem; } h3 { font-size: 1.05rem; }
button { font: inherit; font-size: 0.85rem; padding: 0.35em 0.7em; min-height: 2.1em; color: var(--ink); background: var(--tint); border: 1px solid var(--line); border-radius: 0.35em; cursor: pointer; }
button:focus-visible, svg:focus-visible, input:focus-visible { outline: 3px solid #2f7de1; outline-offset: 2px; }
#theme { float: right; }
nav a { margin-right: 1.2em; } a { color: inherit; }
figure { margin: 0; }
figcaption, .note { color: var(--faint); font-size: 0.9rem; }
code { font: 0.85rem/1.4 "DejaVu Sans Mono", monospace; background: var(--tint); padding: 0.1em 0.35em; border-radius: 0.25em; }
code:empty { display: none; }
.chart { margin: 1rem 0 2rem; }
.panels { display: grid; gap: 1.2rem; grid-template-columns: repeat(auto-fit, minmax(min(100%, max(22rem, 100% / var(--columns, 1) - 2rem)), 1fr)); }
.panel { position: relative; min-width: 0; }
.panel svg { display: block; width: 100%; touch-action: pan-y; user-select: none; font-size: 0.8rem; cursor: crosshair; }
.panel .label { font-size: 0.85rem; }
.panel text { fill: var(--ink); } .panel .grid { stroke: var(--line); } .panel .rule { stroke: var(--faint); stroke-dasharray: 6 4; }
.panel .cell { stroke: var(--paper); stroke-width: 0.5; } .mark * { fill: none; stroke: var(--mark); stroke-width: 2.5; }
input[type=checkbox] { width: 1.1em; height: 1.1em; vertical-align: -0.15em; }
.bar, .legend, .command { display: flex; flex-wrap: wrap; gap: 0.5rem; align-items: center; font-size: 0.85rem; }
.legend { margin: 0.5rem 0; } .legend svg { width: 2.6em; height: 0.95em; margin-right: 0.4em; vertical-align: -0.1em; }
[aria-pressed=false] { opacity: 0.45; text-decoration: line-through; }
.command { min-height: 2.6em; margin-top: 0.4rem; }
.tip { position: absolute; pointer-events: none; z-index: 2; max-width: 20rem; padding: 0.4em 0.7em; font-size: 0.85rem; background: var(--paper); color: var(--ink); border: 1px solid var(--faint); border-radius: 0.35em; box-shadow: 0 2px 8px #0005; }
table { border-collapse: collapse; font-size: 0.85rem; display: block; overflow-x: auto; overflow-wrap: normal; }
th, td { padding: 0.15em 0.7em; border-bottom: 1px solid var(--line); text-align: left; }
.number { text-align: right; font-variant-numeric: tabular-nums; }
.clips .grid { display: grid; gap: 1rem; grid-template-columns: repeat(auto-fill, minmax(min(100%, 18rem), 1fr)); margin-top: 0.7rem; }
video, img { display: block; width: 100%; background: #000; border-radius: 0.25em; }
.picture img { width: auto; max-width: min(100%, 60rem); margin-bottom: 1rem; }
.views { display: grid; gap: 1.5rem; grid-template-columns: repeat(auto-fit, minmax(min(100%, 20rem), 1fr)); }
.views img { image-rendering: pixelated; border-radius: 0; } .views input { width: 100%; margin: 0; }
.pair { position: relative; } .pair img + img { position: absolute; inset: 0; }
.slider img + img { clip-path: inset(0 0 0 var(--at, 50%)); }
.blink img + img { animation: blink 1s steps(1) infinite; } @keyframes blink { 50% { opacity: 0; } }
)";

Json json_number(double value) {
  return std::isfinite(value) ? Json(value) : Json(nullptr);
}

std::string html_color(std::uint32_t rgb) {
  return fmt::format("#{:06x}", rgb);
}

Json json_of(const Axis& axis) {
  Json tics = Json::array();
  for (const auto& [at, name] : axis.tics) tics.push_back({at, name});
  return {{"label", axis.label},
          {"log", axis.log},
          {"minimum", json_number(axis.minimum)},
          {"maximum", json_number(axis.maximum)},
          {"tics", std::move(tics)}};
}

Json json_of(const Panel& panel, const Series& series) {
  Json points = Json::array();
  for (const Point& p : series.points) {
    points.push_back({json_number(p.x), json_number(p.y), json_number(p.x_low),
                      json_number(p.x_high), json_number(p.y_low), json_number(p.y_high),
                      p.command});
  }
  return {{"name", chart_layout::name_in(panel, series)},
          {"color", html_color(series.style.color)},
          {"dash", series.style.dash},
          {"marker", series.style.marker},
          {"hollow", series.style.hollow},
          {"line", series.line},
          {"markers", series.markers},
          {"faint", series.faint},
          {"points", std::move(points)}};
}

Json json_of(const Panel& panel) {
  Json json = {{"title", panel.title},    {"x", json_of(panel.x)},  {"y", json_of(panel.y)},
               {"series", Json::array()}, {"cells", Json::array()}, {"rules", Json::array()},
               {"remarks", Json::array()}};
  for (const Series& series : panel.series) json["series"].push_back(json_of(panel, series));
  for (const Cell& cell : panel.cells) {
    json["cells"].push_back({cell.x_low, cell.x_high, cell.y_low, cell.y_high, cell.kind, cell.x,
                             cell.y, cell.command});
  }
  for (const Rule& rule : panel.rules) {
    json["rules"].push_back({{"at", rule.at},
                             {"vertical", rule.vertical},
                             {"right", chart_layout::is_label_right(panel, rule)},
                             {"label", rule.label}});
  }
  for (const Remark& remark : panel.remarks) {
    json["remarks"].push_back({{"x", remark.x}, {"y", remark.y}, {"text", remark.text}});
  }
  return json;
}

/// As the text of a script element, which "</" would end.
std::string script_text(const Json& json) {
  std::string text = json.dump();
  for (std::size_t at = text.find("</"); at != std::string::npos; at = text.find("</", at + 3)) {
    text.insert(at + 1, "\\");
  }
  return text;
}

}  // namespace

std::string html_page(const std::string& title, const std::string& body) {
  return fmt::format(
      "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">"
      "<link rel=\"icon\" href=\"data:,\"><title>{0}</title>\n<style>{1}</style></head><body>\n"
      "<button type=\"button\" id=\"theme\">light or dark</button>\n<h1>{0}</h1>\n{2}\n"
      "<script>{3}{4}{5}</script></body></html>\n",
      escape_html(title), kStyle, body, kPageHelpers, kPanelScript, kPageScript);
}

std::string html_chart(const Chart& chart) {
  Json json = {{"title", chart.title},
               {"columns", chart.columns},
               {"kinds", Json::array()},
               {"panels", Json::array()}};
  for (const CellKind& kind : chart.kinds) {
    json["kinds"].push_back(
        {{"name", kind.name}, {"letter", kind.letter}, {"color", html_color(kind.color)}});
  }
  for (const Panel& panel : chart.panels) json["panels"].push_back(json_of(panel));
  return fmt::format(
      "<div class=\"chart\"><h3>{}</h3><p class=\"note\">{}</p>"
      "<script type=\"application/json\">{}</script></div>\n",
      escape_html(chart.title), escape_html(chart.subtitle), script_text(json));
}

std::string html_command(const std::string& command) {
  return fmt::format(
      "<div class=\"command\"><code>{}</code><button type=\"button\" class=\"copy\">copy</button>"
      "</div>",
      escape_html(command));
}

}  // namespace taut::chart
