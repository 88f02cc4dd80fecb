#include "render/chart/html_page.h"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <string_view>

#include "render/chart/chart.h"
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

// The script of every page: charts with values, series that hide, logarithms and zoom; commands to
// copy; clips that play together. What it draws is in the page's own JSON.

const std::string_view kPageHelpers = R"js('use strict';
const SVG = 'http://www.w3.org/2000/svg';
const dark = () => document.documentElement.dataset.theme
  ? document.documentElement.dataset.theme === 'dark'
  : matchMedia('(prefers-color-scheme: dark)').matches;
const make = (name, attributes, parent, text) => {
  const node = document.createElementNS(parent instanceof SVGElement || name === 'svg' ? SVG
    : 'http://www.w3.org/1999/xhtml', name);
  for (const key in attributes) node.setAttribute(key, attributes[key]);
  if (text !== undefined) node.textContent = text;
  if (parent) parent.appendChild(node);
  return node;
};
// A colour of a series on this background: the same in both, but for what the dark would swallow.
const shown = (color) => {
  if (!dark()) return color;
  const rgb = [1, 3, 5].map((i) => parseInt(color.slice(i, i + 2), 16));
  const grey = (0.299 * rgb[0] + 0.587 * rgb[1] + 0.114 * rgb[2]) / 255;
  if (grey > 0.35) return color;
  return `rgb(${rgb.map((c) => Math.round(c + (255 - c) * 0.55)).join(',')})`;
};
const power = (k) => (k >= -2 && k <= 3 ? String(Number((10 ** k).toPrecision(1)))
  : `10${k < 0 ? '⁻' : ''}${[...String(Math.abs(k))].map((c) => '⁰¹²³⁴⁵⁶⁷⁸⁹'[c]).join('')}`);
const text_of = (v) => {
  if (v === null || v === undefined) return '-';
  const size = Math.abs(v);
  if (size !== 0 && (size < 1e-3 || size >= 1e6)) return v.toExponential(2);
  return String(Number(v.toPrecision(4)));
};
async function copy(text, where) {
  try {
    await navigator.clipboard.writeText(text);
  } catch (error) {  // pages from files may not reach the clipboard otherwise
    const area = make('textarea', {style: 'position:fixed;opacity:0'}, document.body);
    area.value = text;
    area.select();
    document.execCommand('copy');
    area.remove();
  }
  where.textContent = 'copied';
  setTimeout(() => { where.textContent = 'copy'; }, 1500);
}

const DASHES = ['', '12 5', '3 4', '14 5 3 5', '7 4', '18 4'];
const MARKERS = ['M-4 0a4 4 0 1 0 8 0a4 4 0 1 0-8 0', 'M-4-4h8v8h-8z', 'M0-5L5 4H-5z',
  'M0-5L5 0L0 5L-5 0z', 'M0 5L5-4H-5z', 'M-5 0H5M0-5V5', 'M-4-4L4 4M4-4L-4 4',
  'M0-5L5-1L3 4H-3L-5-1z', 'M-1-1h2v2h-2z'];
)js";

const std::string_view kPageScript = R"js(class Chart {
  constructor(root, index) {
    this.root = root;
    this.index = index;
    this.data = JSON.parse(root.querySelector('script').textContent);
    this.hidden = new Set();
    this.command = '';
    const legend = make('div', {class: 'legend'}, root);
    this.panels = make('div', {class: 'panels'}, root);
    this.panels.style.setProperty('--columns', this.data.columns);
    const line = make('div', {class: 'command'}, root);
    this.said = make('span', {role: 'status'}, line, '');
    this.code = make('code', {}, line, '');
    this.button = make('button', {type: 'button', hidden: ''}, line, 'copy');
    this.button.onclick = () => this.copy();
    this.list = [];
    for (const data of this.data.panels) this.list.push(new Panel(this, data));
    const names = new Map();
    for (const panel of this.data.panels)
      for (const series of panel.series)
        if (series.name && !names.has(series.name) && series.points.some((p) => p[0] !== null &&
          p[1] !== null && (!panel.x.log || p[0] > 0) && (!panel.y.log || p[1] > 0)))
          names.set(series.name, series);
    this.data.kinds.forEach((kind, k) => {
      if (this.data.panels.some((panel) => panel.cells.some((cell) => cell[4] === k)))
        names.set(kind.name, {...kind, kind: true});
    });
    for (const [name, look] of names) {
      const button = make('button', {type: 'button', 'aria-pressed': 'true'}, legend);
      const swatch = make('svg', {viewBox: '0 0 40 14', 'aria-hidden': 'true'}, button);
      this.paint(swatch, look);
      button.append(name);
      button.onclick = () => {
        const hide = !this.hidden.delete(name);
        if (hide) this.hidden.add(name);
        button.setAttribute('aria-pressed', String(!hide));
        this.draw();
      };
      this.repaint = [...(this.repaint || []), () => this.paint(swatch, look)];
    }
  }
  paint(swatch, look) {
    swatch.replaceChildren();
    const color = look.kind ? look.color : shown(look.color);
    if (look.kind) return make('rect', {x: 12, y: 1, width: 14, height: 12, fill: color, stroke: 'var(--faint)'}, swatch);
    if (look.line) make('path', {d: 'M0 7H40', stroke: color, 'stroke-width': 2,
      'stroke-dasharray': DASHES[look.dash % DASHES.length]}, swatch);
    if (look.markers) make('path', {d: MARKERS[look.marker % MARKERS.length], stroke: color,
      fill: look.hollow ? 'var(--paper)' : color, transform: 'translate(20 7)'}, swatch);
    return swatch;
  }
  is_hidden(name) { return this.hidden.has(name); }
  draw() {
    for (const panel of this.list) { panel.hide(); panel.at = null; panel.draw(); }
  }
  show(text, command) {
    this.said.textContent = text;
    this.command = command || '';
    this.code.textContent = this.command;
    this.button.hidden = !this.command;
  }
  copy() { if (this.command) copy(this.command, this.button); }
}

const charts = [...document.querySelectorAll('.chart')].map((root, i) => new Chart(root, i));
const redraw = () => charts.forEach((chart) => {
  chart.draw();
  (chart.repaint || []).forEach((paint) => paint());
});
matchMedia('(prefers-color-scheme: dark)').addEventListener('change', redraw);
const theme = document.querySelector('#theme');
if (theme) theme.onclick = () => {
  document.documentElement.dataset.theme = dark() ? 'light' : 'dark';
  redraw();
};
for (const button of document.querySelectorAll('button.copy'))
  button.onclick = () => copy(button.previousElementSibling.textContent, button);
for (const group of document.querySelectorAll('.clips')) {
  const clips = [...group.querySelectorAll('video')];
  const [play, again] = group.querySelectorAll('button.all');
  play.onclick = () => {
    const stop = clips.some((clip) => !clip.paused);
    clips.forEach((clip) => (stop ? clip.pause() : clip.play()));
  };
  again.onclick = () => clips.forEach((clip) => { clip.currentTime = 0; clip.play(); });
}
)js";

// The script of a chart's panel: what it draws, and what is chosen, zoomed and copied in it.

const std::string_view kPanelScript = R"js(class Panel {
  constructor(chart, data) {
    this.chart = chart;
    this.data = data;
    this.log = {x: data.x.log, y: data.y.log};
    this.at = null;  // what is chosen
    const figure = make('figure', {class: 'panel'}, chart.panels);
    if (data.title) make('figcaption', {}, figure, data.title);
    make('div', {class: 'label'}, figure, data.y.label);
    this.svg = make('svg', {tabindex: 0, role: 'application', 'aria-label':
      `${data.title || chart.data.title}. Arrows choose a point, Enter copies its command, plus ` +
      'and minus zoom, 0 shows all, x and y change an axis between linear and logarithmic.'}, figure);
    const bar = make('div', {class: 'bar'}, figure);
    for (const axis of ['x', 'y']) {
      if (!this.may_be_log(axis)) continue;
      const label = make('label', {}, bar);
      const box = make('input', {type: 'checkbox'}, label);
      box.checked = this.log[axis];
      label.append(` log ${axis}`);
      box.onchange = () => this.set_log(axis, box.checked);
      this[`box_${axis}`] = box;
    }
    for (const [name, title, act] of [['+', 'zoom in', () => this.zoom(0.5)],
      ['−', 'zoom out', () => this.zoom(2)], ['all', 'show all', () => this.all()]]) {
      make('button', {type: 'button', title, 'aria-label': title}, bar, name).onclick = act;
    }
    this.tip = make('div', {class: 'tip', hidden: ''}, figure);
    this.mark = make('g', {}, this.svg);
    this.all(true);
    this.svg.addEventListener('pointermove', (event) => this.move(event));
    this.svg.addEventListener('pointerleave', () => { if (!this.drag) this.hide(); });
    this.svg.addEventListener('pointerdown', (event) => this.down(event));
    this.svg.addEventListener('pointerup', (event) => this.up(event));
    this.svg.addEventListener('dblclick', () => this.all());
    this.svg.addEventListener('keydown', (event) => this.key(event));
    new ResizeObserver(() => requestAnimationFrame(() => this.resized())).observe(figure);
  }
  resized() {
    const width = this.svg.parentNode.clientWidth;
    if (width !== this.width) this.draw();
    this.width = width;
  }
  // Everything that can be chosen, as it stands in the data.
  points() {
    const list = [];
    this.data.series.forEach((series, s) => {
      if (this.chart.is_hidden(series.name) || !series.markers) return;
      series.points.forEach((p, i) => list.push({series, s, i, p, x: p[0], y: p[1], command: p[6]}));
    });
    return list.filter((one) => this.inside(one.x, one.y));
  }
  values(axis) {
    const k = axis === 'x' ? 0 : 1;
    const list = this.data.cells.flatMap((c) => [c[2 * k], c[2 * k + 1]]);
    for (const series of this.data.series)
      if (!this.chart.is_hidden(series.name)) list.push(...series.points.map((p) => p[k]));
    return list.filter((v) => v !== null && (!this.log[axis] || v > 0));
  }
  may_be_log(axis) {
    return this.data[axis].log || this.values(axis).some((v) => v > 0);
  }
  to(axis, v) { return this.log[axis] ? Math.log10(v) : v; }
  from(axis, v) { return this.log[axis] ? 10 ** v : v; }
  range(axis) {
    const given = this.data[axis], all = this.values(axis).map((v) => this.to(axis, v));
    let low = Math.min(...all), high = Math.max(...all);
    if (!all.length) [low, high] = [0, 1];
    const margin = this.data.cells.length ? 0 : (high - low || 1) * 0.05;
    [low, high] = [low - margin, high + margin];
    const usable = (v) => v !== null && (!this.log[axis] || v > 0);
    if (usable(given.minimum)) low = Math.max(low, this.to(axis, given.minimum));
    if (usable(given.maximum)) high = Math.min(high, this.to(axis, given.maximum));
    return high > low ? [low, high] : [low - 0.5, low + 0.5];
  }
  all(quiet) {
    this.view = {x: this.range('x'), y: this.range('y')};
    if (!quiet) this.draw();
  }
  set_log(axis, on) {
    this.log[axis] = on;
    if (this[`box_${axis}`]) this[`box_${axis}`].checked = on;
    this.all();
  }
  zoom(factor) {
    for (const axis of ['x', 'y']) {
      const [low, high] = this.view[axis];
      const middle = this.at && this.at[axis] !== undefined ? this.to(axis, this.at[axis])
        : (low + high) / 2;
      this.view[axis] = [middle - (high - low) / 2 * factor, middle + (high - low) / 2 * factor];
    }
    this.draw();
  }
  inside(x, y) {
    const ok = (axis, v) => v !== null && (!this.log[axis] || v > 0) &&
      this.to(axis, v) >= this.view[axis][0] && this.to(axis, v) <= this.view[axis][1];
    return ok('x', x) && ok('y', y);
  }
  sx(v) {
    const [low, high] = this.view.x;
    return this.left + (this.to('x', v) - low) / (high - low) * (this.right - this.left);
  }
  sy(v) {
    const [low, high] = this.view.y;
    return this.bottom - (this.to('y', v) - low) / (high - low) * (this.bottom - this.top);
  }
  tics(axis, room) {
    const [low, high] = this.view[axis];
    const named = this.data[axis].tics.filter(([v]) => this.to(axis, v) >= low - 1e-9 &&
      this.to(axis, v) <= high + 1e-9);
    if (named.length > 1) return named;
    const most = Math.max(2, Math.floor(room / (axis === 'x' ? 70 : 40)));
    const list = [];
    if (this.log[axis] && high - low > 1) {
      const every = Math.ceil((high - low) / most);
      for (let k = Math.ceil(low); k <= high; k += every) list.push([10 ** k, power(k)]);
    } else {
      const [a, b] = [this.from(axis, low), this.from(axis, high)];
      const rough = (b - a) / most, unit = 10 ** Math.floor(Math.log10(rough));
      const step = [1, 2, 5, 10].map((k) => k * unit).find((k) => k >= rough);
      for (let v = Math.ceil(a / step) * step; v <= b + step * 1e-9; v += step)
        list.push([v, text_of(Math.abs(v) < step * 1e-9 ? 0 : v)]);
    }
    return list;
  }
  draw() {
    const width = this.svg.parentNode.clientWidth;
    if (!width) return;
    const em = parseFloat(getComputedStyle(this.svg).fontSize);
    const height = Math.max(260, Math.min(width * 0.62, innerHeight * 0.75));
    Object.assign(this, {size: Math.max(1, em / 13), left: 3.6 * em, right: width - em, top: em,
      bottom: height - 3.4 * em});
    this.svg.replaceChildren();
    this.svg.setAttribute('viewBox', `0 0 ${width} ${height}`);
    this.svg.style.height = `${height}px`;
    const clip = `clip${this.chart.index}-${this.chart.list.indexOf(this)}`;
    const add = (name, attributes, parent, text) => make(name, attributes, parent || this.svg, text);
    add('rect', {x: this.left, y: this.top, width: this.right - this.left,
      height: this.bottom - this.top}, add('clipPath', {id: clip}));
    for (const [v, name] of this.tics('x', this.right - this.left)) {
      const x = this.sx(v);
      add('path', {class: 'grid', d: `M${x} ${this.top}V${this.bottom}`});
      add('text', {x, y: this.bottom + 1.3 * em, 'text-anchor': 'middle'}, null, name);
    }
    for (const [v, name] of this.tics('y', this.bottom - this.top)) {
      const y = this.sy(v);
      add('path', {class: 'grid', d: `M${this.left} ${y}H${this.right}`});
      add('text', {x: this.left - 0.4 * em, y: y + 0.35 * em, 'text-anchor': 'end'}, null, name);
    }
    add('text', {x: (this.left + this.right) / 2, y: height - 0.5 * em, 'text-anchor': 'middle',
      class: 'label'}, null, this.data.x.label);
    const inner = add('g', {'clip-path': `url(#${clip})`});
    for (const cell of this.data.cells) this.draw_cell(cell, inner, em);
    for (const rule of this.data.rules) {
      const v = rule.vertical, at = v ? this.sx(rule.at) : this.sy(rule.at);
      if (!Number.isFinite(at)) continue;
      add('path', {class: 'rule', d: v ? `M${at} ${this.top}V${this.bottom}`
        : `M${this.left} ${at}H${this.right}`}, inner);
      add('text', v ? {transform: `translate(${at + 0.3 * em} ${this.top + 0.5 * em}) rotate(90)`}
        : rule.right ? {x: this.right - 0.4 * em, y: at - 0.3 * em, 'text-anchor': 'end'}
        : {x: this.left + 0.4 * em, y: at - 0.3 * em}, inner, rule.label);
    }
    for (const series of this.data.series)
      if (!this.chart.is_hidden(series.name)) this.draw_series(series, inner);
    for (const remark of this.data.remarks)
      add('text', {x: this.left + remark.x * (this.right - this.left), 'text-anchor': 'middle',
        y: this.bottom - remark.y * (this.bottom - this.top)}, null, remark.text);
    this.mark = add('g', {class: 'mark'});
    if (this.at) this.choose(this.at);
  }
  draw_cell(cell, parent, em) {
    const [x0, x1, y0, y1, kind] = cell, look = this.chart.data.kinds[kind];
    if (this.chart.is_hidden(look.name)) return;
    const box = {x: this.sx(x0), y: this.sy(y1), width: this.sx(x1) - this.sx(x0),
      height: this.sy(y0) - this.sy(y1)};
    make('rect', {...box, fill: look.color, class: 'cell'}, parent);
    if (Math.min(box.width, box.height) < 1.3 * em) return;
    const bright = parseInt(look.color.slice(1, 3), 16) + 2 * parseInt(look.color.slice(3, 5), 16);
    make('text', {x: box.x + box.width / 2, y: box.y + box.height / 2 + 0.35 * em, 'text-anchor':
      'middle', style: `fill:${bright > 330 ? '#000' : '#fff'}`}, parent, look.letter);
  }
  draw_series(series, parent) {
    const on_map = this.data.cells.length > 0, color = on_map ? series.color : shown(series.color);
    const group = make('g', {opacity: series.faint ? 0.4 : 1}, parent);
    let path = '', pen = 'M';
    for (const p of series.points) {
      const [x, y] = [this.sx(p[0]), this.sy(p[1])];
      const drawn = p[0] !== null && p[1] !== null && Number.isFinite(x) && Number.isFinite(y);
      if (series.line && drawn) path += `${pen}${x.toFixed(1)} ${y.toFixed(1)}`;
      pen = drawn ? 'L' : 'M';
      if (!drawn || !series.markers) continue;
      if (p[2] !== null) make('path', {stroke: color, 'stroke-width': this.size,
        d: `M${this.sx(p[2])} ${y}H${this.sx(p[3])}`}, group);
      make('path', {d: MARKERS[series.marker % MARKERS.length], stroke: color, 'stroke-width': 1.5,
        fill: series.hollow ? 'var(--paper)' : color, transform: `translate(${x} ${y}) scale(${this.size})`}, group);
    }
    if (path && on_map) make('path', {d: path, stroke: '#fff', fill: 'none', 'stroke-width': 5 * this.size}, group);
    if (path) make('path', {d: path, stroke: color, fill: 'none', 'stroke-width': 2 * this.size,
      'stroke-dasharray': DASHES[series.dash % DASHES.length]}, group);
  }
  // Chosen: a point, or a cell as {cell}.
  choose(one) {
    this.at = one;
    const lines = [], chart = this.chart;
    const line = (axis, v, low, high) => {
      const spread = low === null || low === undefined ? '' : ` (${text_of(low)} to ${text_of(high)})`;
      lines.push(`${this.data[axis].label}: ${text_of(v)}${spread}`);
    };
    let x, y;
    if (one.cell) {
      const [x0, x1, y0, y1, kind, vx, vy, command] = one.cell;
      lines.push(chart.data.kinds[kind].name);
      line('x', vx);
      line('y', vy);
      Object.assign(one, {x: vx, y: vy, command});
      [x, y] = [(this.sx(x0) + this.sx(x1)) / 2, (this.sy(y0) + this.sy(y1)) / 2];
      this.mark.replaceChildren();
      make('rect', {x: this.sx(x0), y: this.sy(y1), width: this.sx(x1) - this.sx(x0),
        height: this.sy(y0) - this.sy(y1)}, this.mark);
    } else {
      lines.push(one.series.name || one.series.of);
      line('x', one.x, one.p[2], one.p[3]);
      line('y', one.y, one.p[4], one.p[5]);
      [x, y] = [this.sx(one.x), this.sy(one.y)];
      this.mark.replaceChildren();
      make('circle', {cx: x, cy: y, r: 8 * this.size}, this.mark);
    }
    this.tip.hidden = false;
    this.tip.replaceChildren();
    lines.forEach((text, i) => make(i ? 'div' : 'b', {}, this.tip, text));
    const width = this.svg.parentNode.clientWidth;
    this.tip.style.left = `${Math.max(0, Math.min(x + 14, width - this.tip.offsetWidth))}px`;
    this.tip.style.top = `${this.svg.offsetTop + y + 14}px`;
    chart.show(lines.join(', '), one.command);
  }
  hide() { this.tip.hidden = true; this.mark.replaceChildren(); }
  place(event) {
    const box = this.svg.getBoundingClientRect();
    return [event.clientX - box.left, event.clientY - box.top];
  }
  nearest([x, y]) {
    let best = null, least = 40 ** 2;
    for (const one of this.points()) {
      const d = (this.sx(one.x) - x) ** 2 + (this.sy(one.y) - y) ** 2;
      if (d < least) [best, least] = [one, d];
    }
    if (best) return best;
    const cell = this.data.cells.find((c) => !this.chart.is_hidden(this.chart.data.kinds[c[4]].name) &&
      x >= this.sx(c[0]) && x < this.sx(c[1]) && y <= this.sy(c[2]) && y > this.sy(c[3]));
    return cell ? {cell} : null;
  }
  move(event) {
    const here = this.place(event);
    if (this.drag) {
      const [a, b] = [this.drag, here];
      this.mark.replaceChildren();
      make('rect', {x: Math.min(a[0], b[0]), y: Math.min(a[1], b[1]), width: Math.abs(a[0] - b[0]),
        height: Math.abs(a[1] - b[1])}, this.mark);
      return;
    }
    const one = this.nearest(here);
    if (one) this.choose(one); else this.hide();
  }
  down(event) {
    if (event.pointerType === 'mouse' && event.button === 0) this.drag = this.place(event);
  }
  up(event) {
    const [a, b] = [this.drag || this.place(event), this.place(event)];
    this.drag = null;
    if (Math.abs(a[0] - b[0]) < 8 || Math.abs(a[1] - b[1]) < 8) {
      const one = this.nearest(b);
      if (one) { this.choose(one); this.chart.copy(); }
      return;
    }
    const back = (v, low, high, range) => range[0] + (v - low) / (high - low) * (range[1] - range[0]);
    this.view = {
      x: [a[0], b[0]].sort((p, q) => p - q).map((v) => back(v, this.left, this.right, this.view.x)),
      y: [a[1], b[1]].sort((p, q) => q - p).map((v) => back(v, this.bottom, this.top, this.view.y)),
    };
    this.draw();
  }
  key(event) {
    const key = event.key;
    const sideways = key === 'ArrowRight' ? 1 : key === 'ArrowLeft' ? -1 : 0;
    const across = key === 'ArrowUp' ? 1 : key === 'ArrowDown' ? -1 : 0;
    if (sideways || across) this.step(sideways, across);
    else if (key === 'Enter' || key === 'c') this.chart.copy();
    else if (key === '+' || key === '=') this.zoom(0.5);
    else if (key === '-') this.zoom(2);
    else if (key === '0' || key === 'Escape') this.all();
    else if (key === 'x' || key === 'y') { if (this.may_be_log(key)) this.set_log(key, !this.log[key]); }
    else return;
    event.preventDefault();
  }
  // Along a series or from one to the next; from a cell to its neighbour.
  step(sideways, across) {
    if (this.data.cells.length) {
      const cells = this.data.cells, now = this.at && this.at.cell ? this.at.cell : cells[0];
      const along = sideways ? 0 : 2, kept = sideways ? 2 : 0, sign = sideways || across;
      const next = cells.filter((c) => c[kept] === now[kept] && sign * (c[along] - now[along]) > 0)
        .sort((a, b) => sign * (a[along] - b[along]))[0];
      return this.choose({cell: this.at && this.at.cell ? next || now : now});
    }
    const all = this.points();
    if (!all.length) return undefined;
    const now = this.at && all.find((one) => one.s === this.at.s && one.i === this.at.i);
    if (!now) return this.choose(all[0]);
    if (sideways) {
      const own = all.filter((one) => one.s === now.s).sort((a, b) => a.x - b.x);
      const next = own[own.indexOf(now) + sideways];
      return this.choose(next || now);
    }
    const rows = [...new Set(all.map((one) => one.s))];
    const row = rows[(rows.indexOf(now.s) + across + rows.length) % rows.length];
    const others = all.filter((one) => one.s === row);
    return this.choose(others.reduce((a, b) =>
      Math.abs(this.sx(b.x) - this.sx(now.x)) < Math.abs(this.sx(a.x) - this.sx(now.x)) ? b : a));
  }
}
)js";

}  // namespace taut::chart
