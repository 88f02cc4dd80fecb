// Pages in a browser: what a reader does with charts and clips, at sizes from a phone to a wall.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "render/golden/golden.h"
#include "tests/cli/swing_scene.h"
#include "tests/support/folder.h"
#include "tests/support/program.h"

namespace taut {
namespace {

namespace fs = std::filesystem;

// Before everything else of the page.
constexpr const char* kWatch =
    "<script>window.faults = []; addEventListener('error', (e) => faults.push(e.message)); "
    "addEventListener('unhandledrejection', (e) => faults.push(String(e.reason)));</script>";

// A reader's actions; their outcome is written into the page.
constexpr const char* kRead = R"js(<script>
addEventListener('load', async () => {
  const seen = {faults, charts: [], clips: []};
  const rest = () => new Promise((done) => setTimeout(done, 60));
  const empty = () => [...document.querySelectorAll('.panel svg')].some((svg) => !svg.querySelector('path'));
  for (let i = 0; i < 100 && empty(); ++i) await rest();
  for (const root of document.querySelectorAll('.chart')) {
    const one = {}, svg = root.querySelector('.panel svg'), code = root.querySelector('.command code');
    const key = (name) => svg.dispatchEvent(new KeyboardEvent('keydown', {key: name, bubbles: true}));
    const texts = () => [...svg.querySelectorAll('text')].map((node) => node.textContent).join('|');
    const colors = () => [...new Set([...svg.querySelectorAll('[stroke^="#"],[stroke^="rgb"],.cell')]
      .map((node) => node.getAttribute('stroke') || node.getAttribute('fill')))];
    const drawn = () => svg.querySelectorAll('path,rect').length -
      svg.querySelectorAll('.mark path,.mark rect').length;
    one.drawn = drawn();
    svg.focus();
    one.focused = document.activeElement === svg;
    key('ArrowRight');
    one.said = root.querySelector('[role=status]').textContent;
    one.command = code.textContent;
    key('ArrowUp');
    if (root.querySelector('[role=status]').textContent === one.said) key('ArrowDown');
    one.said_above = root.querySelector('[role=status]').textContent;
    key('Enter');
    const button_of = root.querySelector('.command button');
    for (let i = 0; i < 50 && button_of.textContent === 'copy'; ++i) await rest();
    one.copied = button_of.textContent;
    one.whole = texts();
    key('+');
    one.near = texts();
    key('0');
    one.all = texts();
    const log = root.querySelector('.bar input');
    if (log) {
      log.click();
      one.other_axis = texts();
      log.click();
      one.same_axis = texts();
    }
    const before = colors(), button = root.querySelector('.legend button');
    const count = drawn();
    button.click();
    one.pressed = button.getAttribute('aria-pressed');
    one.fewer = count - drawn();
    one.new_colors = colors().filter((color) => !before.includes(color));
    button.click();
    one.again = drawn() - count;
    // The pointer, over a marker or a cell.
    const mark = svg.querySelector('g[clip-path] path[transform]') || svg.querySelector('.cell');
    const box = mark.getBoundingClientRect();
    const where = {clientX: box.x + box.width / 2, clientY: box.y + box.height / 2, bubbles: true};
    svg.dispatchEvent(new PointerEvent('pointermove', where));
    one.tip = root.querySelector('.tip').textContent;
    one.tip_shown = !root.querySelector('.tip').hidden;
    svg.dispatchEvent(new PointerEvent('pointerleave', {}));
    one.tip_gone = root.querySelector('.tip').hidden;
    // A rectangle drawn with the mouse enlarges.
    const area = svg.getBoundingClientRect();
    const at = (x, y) => ({pointerType: 'mouse', button: 0, bubbles: true,
      clientX: area.x + area.width * x, clientY: area.y + area.height * y});
    svg.dispatchEvent(new PointerEvent('pointerdown', at(0.4, 0.3)));
    svg.dispatchEvent(new PointerEvent('pointermove', at(0.6, 0.5)));
    svg.dispatchEvent(new PointerEvent('pointerup', at(0.6, 0.5)));
    one.enlarged = texts();
    svg.dispatchEvent(new MouseEvent('dblclick', {bubbles: true}));
    one.after = texts();
    seen.charts.push(one);
  }
  for (const clip of document.querySelectorAll('video')) {
    for (let i = 0; i < 100 && clip.readyState < 2; ++i) await rest();
    seen.clips.push({ready: clip.readyState, width: clip.videoWidth, duration: clip.duration});
  }
  seen.overflow = document.documentElement.scrollWidth - innerWidth;
  seen.paper = getComputedStyle(document.body).backgroundColor;
  document.querySelector('#theme').click();
  seen.other_paper = getComputedStyle(document.body).backgroundColor;
  seen.fetched = performance.getEntriesByType('resource').map((entry) => entry.name.slice(0, 40))
    .filter((name) => !name.startsWith('data:'));
  document.body.replaceChildren();
  document.body.dataset.seen = encodeURIComponent(JSON.stringify(seen));
});
</script>)js";

/// A byte for each %XX.
std::string decoded(const std::string& text) {
  std::string out;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] != '%') {
      out += text[i];
      continue;
    }
    out += static_cast<char>(std::stoi(text.substr(i + 1, 2), nullptr, 16));
    i += 2;
  }
  return out;
}

class LongBrowser : public testing::Test {
 protected:
  void SetUp() override {
    for (const char* name : {"chromium", "chromium-browser", "google-chrome"}) {
      const std::string look = std::string("command -v ") + name;
      if (Child({"sh", "-c", look}, "/").wait().code == 0) browser_ = name;
      if (!browser_.empty()) return;
    }
    GTEST_SKIP() << "no Chromium is installed (Debian: chromium)";
  }
  /// The view of a page in a window of that size.
  nlohmann::json seen(std::string page, int width, int height, bool dark = false) const {
    page.insert(page.find("<title>"), kWatch);
    page.insert(page.rfind("</body>"), kRead);
    const fs::path file = folder_.write("read.html", page);
    const ProgramResult outcome =
        Child({browser_, "--headless=new", "--no-sandbox", "--disable-gpu", "--no-first-run",
               "--user-data-dir=" + (folder_.path() / "profile").string(),
               "--host-resolver-rules=MAP * ~NOTFOUND", "--timeout=30000",
               fmt::format("--window-size={},{}", width, height),
               fmt::format("--blink-settings=preferredColorScheme={}", dark ? 0 : 1), "--dump-dom",
               "--virtual-time-budget=60000", "file://" + file.string()},
              folder_.path())
            .wait(std::chrono::seconds(100));
    const std::string mark = "data-seen=\"";
    const std::size_t at = outcome.output.find(mark);
    if (at == std::string::npos) {
      ADD_FAILURE() << outcome.messages << outcome.output.substr(0, 2000);
      return nlohmann::json::object();
    }
    const std::size_t begin = at + mark.size();
    return nlohmann::json::parse(
        decoded(outcome.output.substr(begin, outcome.output.find('"', begin) - begin)));
  }

  Folder folder_;
  std::string browser_;
};

void expect_usable(const nlohmann::json& seen, std::size_t charts, std::size_t clips) {
  EXPECT_EQ(seen.at("faults"), nlohmann::json::array());
  EXPECT_EQ(seen.at("fetched"), nlohmann::json::array());
  EXPECT_LE(seen.at("overflow"), 0) << "the page is wider than its window";
  EXPECT_NE(seen.at("paper"), seen.at("other_paper"));
  ASSERT_EQ(seen.at("charts").size(), charts);
  for (const nlohmann::json& one : seen.at("charts")) {
    EXPECT_GT(one.at("drawn"), 10);
    EXPECT_TRUE(one.at("focused"));
    EXPECT_NE(one.at("said"), "");
    EXPECT_TRUE(one.at("command").get<std::string>().starts_with("taut ")) << one.at("command");
    EXPECT_NE(one.at("said_above"), one.at("said"));
    EXPECT_EQ(one.at("copied"), "copied");
    EXPECT_NE(one.at("near"), one.at("whole"));
    EXPECT_EQ(one.at("all"), one.at("whole"));
    EXPECT_NE(one.at("other_axis"), one.at("whole"));
    EXPECT_EQ(one.at("same_axis"), one.at("whole"));
    EXPECT_EQ(one.at("pressed"), "false");
    EXPECT_GE(one.at("fewer"), 0);
    EXPECT_EQ(one.at("again"), 0);
    EXPECT_EQ(one.at("new_colors"), nlohmann::json::array())
        << "series that stay keep their colours";
    EXPECT_TRUE(one.at("tip_shown"));
    EXPECT_NE(one.at("tip"), "");
    EXPECT_TRUE(one.at("tip_gone"));
    EXPECT_NE(one.at("enlarged"), one.at("whole"));
    EXPECT_EQ(one.at("after"), one.at("whole"));
  }
  ASSERT_EQ(seen.at("clips").size(), clips);
  for (const nlohmann::json& clip : seen.at("clips")) {
    EXPECT_GE(clip.at("ready"), 2);
    EXPECT_EQ(clip.at("width"), 240);
    EXPECT_GT(clip.at("duration"), 0.1);
  }
}

TEST_F(LongBrowser, AReportIsReadFromAPhoneToAWall) {
  folder_.write("swing.toml", swing_scene(0.4));
  const ProgramResult made = run_taut({"report", "swing.toml", "--quick", "--budget", "4",
                                       "--methods", "springs,xpbd,direct", "-q"},
                                      folder_.path());
  ASSERT_EQ(made.code, 0) << made.messages;
  const std::string page = read_file(folder_.path() / "out/swing/report.html");
  const nlohmann::json light = seen(page, 1280, 900);
  const std::size_t charts = light.at("charts").size();
  EXPECT_GE(charts, 4u);
  expect_usable(light, charts, 3);
  EXPECT_EQ(light.at("paper"), "rgb(255, 255, 255)");
  const nlohmann::json dark = seen(page, 1280, 900, true);
  expect_usable(dark, charts, 3);
  EXPECT_EQ(dark.at("paper"), light.at("other_paper"));
  expect_usable(seen(page, 500, 800), charts, 3);  // the narrowest window that there is
  expect_usable(seen(page, 3840, 2160), charts, 3);
}

TEST_F(LongBrowser, GoldensAreInTheSameStyle) {
  const golden::GoldenFailure failure{"throw", "differs by <much>", true};
  const nlohmann::json page = seen(golden::golden_page({&failure, 1}), 500, 800);
  EXPECT_EQ(page.at("faults"), nlohmann::json::array());
  EXPECT_LE(page.at("overflow"), 0);
  EXPECT_NE(page.at("paper"), page.at("other_paper"));
}

}  // namespace
}  // namespace taut
