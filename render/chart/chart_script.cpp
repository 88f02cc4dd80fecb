// From a chart to the program that gnuplot runs. Every place is given to it, so that a caller can
// draw onto the picture and both formats look alike.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>

#include "render/chart/chart_layout.h"
#include "render/chart/gnuplot.h"

namespace taut::chart {
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

}  // namespace taut::chart
