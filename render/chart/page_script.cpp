// The script of every page: charts with values, series that hide, logarithms and zoom; commands to
// copy; clips that play together. What it draws is in the page's own JSON.
#include "render/chart/page_script.h"

namespace taut::chart {

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

}  // namespace taut::chart
