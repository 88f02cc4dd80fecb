#include "render/chart/chart.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include "render/base/atomic_file.h"
#include "render/base/error.h"
#include "render/chart/table.h"

namespace taut::chart {
namespace chart_layout {
namespace {

constexpr double kWide = 0.58;  // mean width of a letter, as a share of its height

// Letters of UTF-8 text, good enough for widths.
std::size_t letters(const std::string& text) {
  return static_cast<std::size_t>(
      std::count_if(text.begin(), text.end(), [](char c) { return (c & 0xc0) != 0x80; }));
}

std::vector<std::string> wrapped(const std::string& text, double width, double height) {
  const auto most = static_cast<std::size_t>(std::max(10.0, width / (kWide * height)));
  std::vector<std::string> lines;
  std::string line, word;
  const auto take = [&] {
    if (word.empty()) return;
    if (!line.empty() && letters(line) + 1 + letters(word) > most)
      lines.push_back(std::move(line)), line.clear();
    line += (line.empty() ? "" : " ") + word;
    word.clear();
  };
  for (const char c : text) {
    if (c == ' ' || c == '\n')
      take();
    else
      word += c;
  }
  take();
  if (!line.empty()) lines.push_back(line);
  return lines;
}

// Something of it lies in the panel: no series of a method that is missing, or that ran nowhere.
bool is_drawn(const Panel& panel, const Series& series) {
  return std::ranges::any_of(series.points, [&](const Point& p) {
    return std::isfinite(p.x) && std::isfinite(p.y) && (!panel.x.log || p.x > 0) &&
           (!panel.y.log || p.y > 0);
  });
}

bool is_drawn(const Chart& chart, std::size_t kind) {
  return std::ranges::any_of(chart.panels, [&](const Panel& panel) {
    return std::ranges::any_of(panel.cells, [&](const Cell& cell) { return cell.kind == kind; });
  });
}

// Names of what is drawn.
std::vector<Entry> legend_entries(const Chart& chart) {
  std::vector<Entry> entries;
  if (!chart.legend) return entries;
  for (const Panel& panel : chart.panels) {
    for (const Series& series : panel.series) {
      const bool known = std::any_of(entries.begin(), entries.end(),
                                     [&](const Entry& e) { return e.name == series.name; });
      if (series.name.empty() || known || !is_drawn(panel, series)) continue;
      entries.push_back({series.name, &series.style, series.line, series.markers, nullptr});
    }
  }
  for (std::size_t k = 0; k < chart.kinds.size(); ++k) {
    const CellKind& kind = chart.kinds[k];
    if (!is_drawn(chart, k)) continue;
    entries.push_back({kind.letter.empty() ? kind.name : kind.letter + "  " + kind.name, nullptr,
                       false, false, &kind});
  }
  return entries;
}

}  // namespace

bool is_label_right(const Panel& panel, const Rule& rule) {
  if (rule.vertical) return false;
  constexpr double kWidth = 0.2, kBelow = 0.01, kAbove = 0.06;  // of the panel, around the label
  constexpr int kSamples = 40;                                  // of a line between two points
  const auto x = x_range(panel), y = y_range(panel);
  const auto share = [](const Axis& axis, std::pair<double, double> range, double v) {
    if (axis.log) return std::log(v / range.first) / std::log(range.second / range.first);
    return (v - range.first) / (range.second - range.first);
  };
  const double height = share(panel.y, y, rule.at);
  int left = 0, right = 0;
  for (const Series& series : panel.series) {
    const std::size_t lines = series.line ? series.points.size() : 0;
    for (std::size_t i = 0; i + 1 < lines; ++i) {
      const Point &a = series.points[i], &b = series.points[i + 1];
      const double ax = share(panel.x, x, a.x), bx = share(panel.x, x, b.x);
      const double ay = share(panel.y, y, a.y), by = share(panel.y, y, b.y);
      for (int k = 0; k <= kSamples; ++k) {
        const double along = ax + (bx - ax) * k / kSamples;
        const double above = ay + (by - ay) * k / kSamples - height;
        if (!(above > -kBelow && above < kAbove)) continue;
        left += along < kWidth;
        right += along > 1 - kWidth;
      }
    }
  }
  return right < left;
}

std::string name_in(const Panel& panel, const Series& series) {
  if (!series.name.empty()) return series.name;
  for (const Series& other : panel.series) {
    if (!other.name.empty() && other.style == series.style) return other.name;
  }
  return {};
}

Layout layout_of(const Chart& chart) {
  Layout layout;
  const double width = chart.width - 2 * kMargin;
  layout.title = wrapped(chart.title, width, kTitle * 1.05);
  layout.subtitle = wrapped(chart.subtitle, width, kText);
  layout.top = kMargin * 0.7 + kLine * (kTitle * static_cast<double>(layout.title.size()) +
                                        kText * static_cast<double>(layout.subtitle.size()));

  layout.legend = legend_entries(chart);
  const double row = 1.6 * kText;
  double x = kMargin, y = 0;
  for (Entry& entry : layout.legend) {
    const double wide =
        (entry.style ? 52 : 26) + kWide * kText * static_cast<double>(letters(entry.name)) + 24;
    if (x > kMargin && x + wide > chart.width - kMargin) x = kMargin, y += row;
    entry.x = x;
    entry.y = y;
    x += wide;
  }
  const double high = layout.legend.empty() ? 0 : y + row;
  layout.bottom = chart.height - kMargin * 0.6 - high;
  for (Entry& entry : layout.legend) entry.y += layout.bottom + row / 2;
  return layout;
}

PlotArea area_in(const Chart& chart, const Layout& layout, std::size_t panel) {
  const std::size_t columns = std::max<std::size_t>(1, chart.columns);
  const std::size_t rows = std::max<std::size_t>(1, (chart.panels.size() + columns - 1) / columns);
  const double wide = (chart.width - kMargin) / static_cast<double>(columns);
  const double high = (layout.bottom - layout.top) / static_cast<double>(rows);
  const double left = kMargin / 2 + wide * static_cast<double>(panel % columns);
  const double top = layout.top + high * static_cast<double>(panel / columns);
  const Panel& p = chart.panels[panel];
  return {left + (p.y.label.empty() ? 50 : 76), top + (p.title.empty() ? 10 : 28), left + wide - 16,
          top + high - (p.x.label.empty() ? 30 : 54)};
}

}  // namespace chart_layout

namespace {

// The axis's own limits, or those of the data with `margin` (a share of the range) around them.
std::pair<double, double> range_of(const Axis& axis, std::pair<double, double> data,
                                   double margin) {
  auto [low, high] = data;
  if (!(low <= high)) low = axis.log ? 1 : 0, high = axis.log ? 10 : 1;
  if (axis.log) {
    const double pad = margin * std::max(std::log10(high / low), 0.3);
    low /= std::pow(10, pad), high *= std::pow(10, pad);
  } else {
    const double pad = margin * (high > low ? high - low : std::max(std::abs(high), 1.0));
    low -= pad, high += pad;
  }
  return {std::isnan(axis.minimum) ? low : axis.minimum,
          std::isnan(axis.maximum) ? high : axis.maximum};
}

void widen(std::pair<double, double>& range, bool log, std::initializer_list<double> values) {
  for (const double v : values) {
    if (!std::isfinite(v) || (log && v <= 0)) continue;
    range = {std::min(range.first, v), std::max(range.second, v)};
  }
}

std::pair<double, double> full_range(const Panel& panel, bool horizontal) {
  const Axis& axis = horizontal ? panel.x : panel.y;
  std::pair<double, double> range{INFINITY, -INFINITY};
  for (const Series& series : panel.series) {
    for (const Point& p : series.points) {
      if (horizontal)
        widen(range, axis.log, {p.x, p.x_low, p.x_high});
      else
        widen(range, axis.log, {p.y, p.y_low, p.y_high});
    }
  }
  for (const Cell& cell : panel.cells) {
    if (horizontal)
      widen(range, axis.log, {cell.x_low, cell.x_high});
    else
      widen(range, axis.log, {cell.y_low, cell.y_high});
  }
  return range_of(axis, range, panel.cells.empty() ? 0.05 : 0);
}

}  // namespace

PlotArea plot_area(const Chart& chart, std::size_t panel) {
  return chart_layout::area_in(chart, chart_layout::layout_of(chart), panel);
}

std::pair<double, double> x_range(const Panel& panel) {
  return full_range(panel, true);
}
std::pair<double, double> y_range(const Panel& panel) {
  return full_range(panel, false);
}

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

// From a chart to the program that gnuplot runs. Every place is given to it, so that a caller can
// draw onto the picture and both formats look alike.

namespace {

using namespace chart_layout;

constexpr const char* kDashes[] = {"solid", "(12,5)", "(3,4)", "(14,5,3,5)", "(7,4)", "(18,4)"};
constexpr int kFilled[] = {7, 5, 9, 13, 11, 3, 2, 15, 1};
constexpr int kHollow[] = {6, 4, 8, 12, 10, 3, 2, 14, 1};

// A text of gnuplot's: between single quotes everything but the quote stands for itself.
std::string literal(const std::string& text) {
  std::string out = "'";
  for (const char c : text) {
    if (c == '\'') {
      out += "’";
    } else {
      out += static_cast<unsigned char>(c) < ' ' ? ' ' : c;
    }
  }
  return out + "'";
}

std::string number(double value) {
  return fmt::format("{:.10g}", value);
}

std::string color(std::uint32_t rgb, bool faint = false) {
  if (faint) {
    std::uint32_t pale = 0;
    for (int shift = 0; shift <= 16; shift += 8) {
      const std::uint32_t c = (rgb >> shift) & 0xff;
      pale |= (255 - (255 - c) * 3 / 10) << shift;
    }
    rgb = pale;
  }
  return fmt::format("rgb '#{:06x}'", rgb);
}

double grey(std::uint32_t rgb) {
  return (0.299 * ((rgb >> 16) & 0xff) + 0.587 * ((rgb >> 8) & 0xff) + 0.114 * (rgb & 0xff)) / 255;
}

std::string power_of_ten(int power) {
  constexpr const char* digits[] = {"⁰", "¹", "²", "³", "⁴", "⁵", "⁶", "⁷", "⁸", "⁹"};
  if (power >= -2 && power <= 3) return number(std::pow(10, power));
  std::string out = power < 0 ? "10⁻" : "10";
  for (const char c : std::to_string(std::abs(power))) out += digits[c - '0'];
  return out;
}

std::string tics_of(const Axis& axis, std::pair<double, double> range, const char* name,
                    double length) {
  std::vector<std::pair<double, std::string>> tics = axis.tics;
  if (tics.empty() && !axis.log)
    return fmt::format("set {}tics autofreq scale 0.6\nset m{}tics\n", name, name);
  if (tics.empty()) {
    const int first = static_cast<int>(std::ceil(std::log10(range.first) - 1e-9));
    const int last = static_cast<int>(std::floor(std::log10(range.second) + 1e-9));
    const int every = std::max(1, static_cast<int>(std::ceil((last - first + 1) * 46 / length)));
    for (int power = first; power <= last; ++power) {
      tics.emplace_back(std::pow(10, power), (power - first) % every ? "" : power_of_ten(power));
    }
    // Less than a decade holds at most one power of ten: name the steps between as well.
    for (int power = first - 1; tics.size() < 3 && last - first < 1 && power <= last; ++power) {
      for (const int step : {2, 5}) {
        const double at = step * std::pow(10, power);
        if (at >= range.first && at <= range.second) tics.emplace_back(at, number(at));
      }
    }
  }
  std::string out = fmt::format("set {}tics scale 0.6 (", name);
  for (std::size_t i = 0; i < tics.size(); ++i) {
    out += fmt::format("{}{} {}", i ? ", " : "", literal(tics[i].second), number(tics[i].first));
  }
  return out + fmt::format(")\nunset m{}tics\n", name);
}

class Script {
 public:
  Script(const Chart& chart, ChartFormat format) : chart_(chart), layout_(layout_of(chart)) {
    const bool svg = format == ChartFormat::svg;
    add("set encoding utf8\nset terminal {} size {},{} noenhanced font 'DejaVu Sans,{}' "
        "background '#ffffff' linewidth 1 {}\n",
        svg ? "svg" : "pngcairo", chart.width, chart.height, number(svg ? kText : kText * 0.75),
        svg ? "dynamic" : "");
    type_scale_ = svg ? 1 : 0.75;  // pngcairo counts in points of 4/3 px
    add("set multiplot\n");
    for (std::size_t i = 0; i < chart.panels.size(); ++i) add_panel(i);
    add_frame();
    add("unset multiplot\n");
  }

  std::string text() && { return std::move(text_); }
  std::vector<std::string> names() && { return std::move(names_); }

 private:
  template <class... T>
  void add(fmt::format_string<T...> format, T&&... values) {
    fmt::format_to(std::back_inserter(text_), format, std::forward<T>(values)...);
  }

  std::string font(double height, bool bold = false) const {
    return fmt::format("font 'DejaVu Sans{},{}'", bold ? ":Bold" : "",
                       number(height * type_scale_));
  }
  // A place in the picture, px from the upper left, as gnuplot's screen coordinates.
  std::string place(double x, double y) const {
    return fmt::format("screen {},{}", number(x / chart_.width), number(1 - y / chart_.height));
  }
  void margins(const PlotArea& area) {
    add("set lmargin at screen {}\nset rmargin at screen {}\nset tmargin at screen {}\n"
        "set bmargin at screen {}\n",
        number(area.left / chart_.width), number(area.right / chart_.width),
        number(1 - area.top / chart_.height), number(1 - area.bottom / chart_.height));
  }

  void add_panel(std::size_t index);
  void add_series(const Series& series, std::size_t index, bool on_map);
  void add_frame();

  const Chart& chart_;
  Layout layout_;
  double type_scale_ = 1;
  std::string text_;
  std::vector<std::string> names_;  // of plots
};

void Script::add_panel(std::size_t index) {
  const Panel& panel = chart_.panels[index];
  const PlotArea area = area_in(chart_, layout_, index);
  const auto x = x_range(panel), y = y_range(panel);
  add("reset\nunset key\nset border 3 lc rgb '#444444'\nset tics nomirror out textcolor rgb "
      "'#222222'\n");
  margins(area);
  add("{}{}", panel.x.log ? "set logscale x\n" : "", panel.y.log ? "set logscale y\n" : "");
  add("set xrange [{}:{}]\nset yrange [{}:{}]\n", number(x.first), number(x.second),
      number(y.first), number(y.second));
  add("{}{}", tics_of(panel.x, x, "x", area.right - area.left),
      tics_of(panel.y, y, "y", area.bottom - area.top));
  if (panel.cells.empty()) add("set grid back lc rgb '#e4e4e4' lt 1 dt solid lw 1\n");
  if (!panel.x.label.empty()) {
    add("set label {} at {} center {}\n", literal(panel.x.label),
        place((area.left + area.right) / 2, area.bottom + 42), font(kText));
  }
  if (!panel.y.label.empty()) {
    add("set label {} at {} center rotate by 90 {}\n", literal(panel.y.label),
        place(area.left - 62, (area.top + area.bottom) / 2), font(kText));
  }
  if (!panel.title.empty()) {
    add("set label {} at {} left {}\n", literal(panel.title), place(area.left, area.top - 14),
        font(kText, true));
  }
  for (const Rule& rule : panel.rules) {
    const std::string at = number(rule.at);
    const bool v = rule.vertical, right = is_label_right(panel, rule);
    const auto range = v ? x : y;
    if (rule.at < range.first || rule.at > range.second) continue;
    add("set arrow from {} to {} nohead back lc rgb '#555555' dt (6,4) lw 1.3\n",
        v ? fmt::format("first {},graph 0", at) : fmt::format("graph 0,first {}", at),
        v ? fmt::format("first {},graph 1", at) : fmt::format("graph 1,first {}", at));
    if (!rule.label.empty()) {
      add("set label {} at {} {} textcolor rgb '#444444' {}\n", literal(rule.label),
          v ? fmt::format("first {},graph 0.985", at)
            : fmt::format("graph {},first {}", right ? 0.99 : 0.01, at),
          v       ? "left rotate by -90 offset character 0.8,0"
          : right ? "right offset character 0,0.7"
                  : "left offset character 0,0.7",
          font(kText * 0.9));
    }
  }
  for (const Remark& remark : panel.remarks) {
    add("set label {} at graph {},{} center textcolor rgb '#333333' front {}\n",
        literal(remark.text), number(remark.x), number(remark.y), font(kText));
  }

  for (std::size_t k = 0; k < chart_.kinds.size(); ++k) {
    add("$kind{} << EOD\n", k);
    for (const Cell& cell : panel.cells) {
      if (cell.kind != k) continue;
      const double cx =
          panel.x.log ? std::sqrt(cell.x_low * cell.x_high) : (cell.x_low + cell.x_high) / 2;
      const double cy =
          panel.y.log ? std::sqrt(cell.y_low * cell.y_high) : (cell.y_low + cell.y_high) / 2;
      add("{} {} {} {} {} {}\n", number(cx), number(cy), number(cell.x_low), number(cell.x_high),
          number(cell.y_low), number(cell.y_high));
    }
    add("EOD\n");
  }
  for (std::size_t s = 0; s < panel.series.size(); ++s) {
    add("$series{} << EOD\n", s);
    for (const Point& p : panel.series[s].points) {
      if (std::isnan(p.x) || std::isnan(p.y)) {
        add("\n");
        continue;
      }
      const auto or_else = [](double v, double w) { return number(std::isnan(v) ? w : v); };
      add("{} {} {} {} {} {}\n", number(p.x), number(p.y), or_else(p.x_low, p.x),
          or_else(p.x_high, p.x), or_else(p.y_low, p.y), or_else(p.y_high, p.y));
    }
    add("EOD\n");
  }

  add("plot NaN notitle");
  names_.emplace_back();
  for (std::size_t k = 0; k < chart_.kinds.size(); ++k) {
    const CellKind& kind = chart_.kinds[k];
    if (std::none_of(panel.cells.begin(), panel.cells.end(),
                     [&](const Cell& c) { return c.kind == k; }))
      continue;
    add(", $kind{} using 1:2:3:4:5:6 with boxxyerror fillstyle solid 1 border lc rgb '#ffffff' "
        "fc {} notitle",
        k, color(kind.color));
    names_.push_back(kind.name);
    if (!kind.letter.empty()) {
      add(", $kind{} using 1:2:({}) with labels textcolor rgb '{}' {} notitle", k,
          literal(kind.letter), grey(kind.color) > 0.5 ? "#333333" : "#ffffff", font(kText * 0.8));
      names_.push_back(kind.name);
    }
  }
  for (const bool faint : {true, false}) {  // what is faint lies below
    for (std::size_t s = 0; s < panel.series.size(); ++s) {
      if (panel.series[s].faint != faint) continue;
      const std::size_t before = text_.size();
      add_series(panel.series[s], s, !panel.cells.empty());
      const auto plots =
          std::count(text_.begin() + static_cast<std::ptrdiff_t>(before), text_.end(), '$');
      names_.insert(names_.end(), static_cast<std::size_t>(plots), name_in(panel, panel.series[s]));
    }
  }
  add("\n");
}

void Script::add_series(const Series& series, std::size_t index, bool on_map) {
  const auto spread = [](const Point& p) {
    return !std::isnan(p.x_low) || !std::isnan(p.x_high) || !std::isnan(p.y_low) ||
           !std::isnan(p.y_high);
  };
  const std::string shade = color(series.style.color, series.faint);
  const std::size_t dash = static_cast<std::size_t>(series.style.dash) % std::size(kDashes);
  const std::size_t marker = static_cast<std::size_t>(series.style.marker) % std::size(kFilled);
  if (std::any_of(series.points.begin(), series.points.end(), spread)) {
    add(", $series{} using 1:2:3:4:5:6 with xyerrorbars pointtype 0 linewidth 1 lc {} notitle",
        index, shade);
  }
  if (series.line) {
    if (on_map) add(", $series{} using 1:2 with lines lw 5 lc rgb '#ffffff' notitle", index);
    add(", $series{} using 1:2 with lines lw {} dashtype {} lc {} notitle", index,
        series.faint ? 1 : 2, kDashes[dash], shade);
  }
  if (series.markers) {
    add(", $series{} using 1:2 with points pt {} ps {} lw 1.5 lc {} notitle", index,
        (series.style.hollow ? kHollow : kFilled)[marker], series.faint ? 0.7 : 1.1, shade);
  }
}

// The titles and the legend: a last plot over the whole picture with nothing in it.
void Script::add_frame() {
  add("reset\nunset key\nunset border\nunset tics\n");
  margins({0, 0, static_cast<double>(chart_.width), static_cast<double>(chart_.height)});
  double y = kMargin * 0.7 + kTitle * 0.6;
  for (const std::string& line : layout_.title) {
    add("set label {} at {} left {}\n", literal(line), place(kMargin, y), font(kTitle, true));
    y += kLine * kTitle;
  }
  for (const std::string& line : layout_.subtitle) {
    add("set label {} at {} left textcolor rgb '#444444' {}\n", literal(line), place(kMargin, y),
        font(kText));
    y += kLine * kText;
  }
  for (const Entry& entry : layout_.legend) {
    if (entry.kind) {
      add("set object rectangle from {} to {} fillstyle solid 1 border lc rgb '#888888' fc {}\n",
          place(entry.x, entry.y - 7), place(entry.x + 16, entry.y + 7), color(entry.kind->color));
    } else {
      const std::size_t dash = static_cast<std::size_t>(entry.style->dash) % std::size(kDashes);
      const std::size_t marker = static_cast<std::size_t>(entry.style->marker) % std::size(kFilled);
      if (entry.line) {
        add("set arrow from {} to {} nohead lw 2 dashtype {} lc {}\n", place(entry.x, entry.y),
            place(entry.x + 42, entry.y), kDashes[dash], color(entry.style->color));
      }
      if (entry.markers) {
        add("set label '' at {} point pt {} ps 1.1 lw 1.5 lc {}\n", place(entry.x + 21, entry.y),
            (entry.style->hollow ? kHollow : kFilled)[marker], color(entry.style->color));
      }
    }
    add("set label {} at {} left {}\n", literal(entry.name),
        place(entry.x + (entry.kind ? 23 : 50), entry.y), font(kText));
  }
  add("set xrange [0:1]\nset yrange [0:1]\nplot NaN notitle\n");
  names_.emplace_back();
}

}  // namespace

std::string gnuplot_script(const Chart& chart, ChartFormat format) {
  return Script(chart, format).text();
}

std::vector<std::string> plot_names(const Chart& chart) {
  return Script(chart, ChartFormat::svg).names();
}

render::ChildResult run_gnuplot(const std::vector<std::string>& command, const std::string& input) {
  render::ChildResult result;
  try {
    result = render::run_child(command, input);
  } catch (const std::system_error& error) {
    throw render::CannotWrite(
        fmt::format("{}; charts are drawn by gnuplot (Debian: gnuplot-nox)", error.what()));
  }
  if (result.status != 0 || result.output.empty()) {
    throw render::CannotWrite(
        fmt::format("gnuplot failed with status {}: {}", result.status, result.errors));
  }
  return result;
}

void require_gnuplot() {
  run_gnuplot({"gnuplot", "--version"}, "");
}

}  // namespace taut::chart
