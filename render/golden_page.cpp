#include "render/golden_page.h"

#include <fmt/format.h>

namespace taut {
namespace {

constexpr const char* kHead = R"html(<!doctype html>
<html lang="en">
<meta charset="utf-8">
<meta name="viewport" content="width=device-width">
<title>Golden pictures that differ</title>
<style>
  body { font: 15px/1.5 sans-serif; margin: 2em; background: #1d1f21; color: #ddd; }
  .views { display: flex; flex-wrap: wrap; gap: 1.5em; }
  figure { margin: 0; }
  img { display: block; width: 480px; image-rendering: pixelated; }
  .pair { position: relative; }
  .pair img + img { position: absolute; inset: 0; }
  .slider img + img { clip-path: inset(0 0 0 var(--at, 50%)); }
  .blink img + img { animation: blink 1s steps(1) infinite; }
  @keyframes blink { 50% { opacity: 0; } }
  input { width: 480px; margin: 0; }
</style>
<h1>Golden pictures that differ</h1>
)html";

constexpr const char* kViews = R"html(<div class="views">
<figure><div class="pair slider"><img src="{0}/golden.png" alt="golden"><img src="{0}/actual.png" alt="actual"></div>
<input type="range" value="50" aria-label="share that is golden"
 oninput="this.previousElementSibling.style.setProperty('--at', this.value + '%')">
<figcaption>golden on the left, actual on the right</figcaption></figure>
<figure><div class="pair blink"><img src="{0}/golden.png" alt="golden"><img src="{0}/actual.png" alt="actual"></div>
<figcaption>blink: golden and actual by turns</figcaption></figure>
<figure><img src="{0}/difference.png" alt="difference"><figcaption>difference, times 8</figcaption></figure>
</div>
)html";

std::string escaped(const std::string& text) {
  std::string result;
  for (const char c : text)
    result += c == '<' ? "&lt;" : c == '>' ? "&gt;" : c == '&' ? "&amp;" : std::string(1, c);
  return result;
}

}  // namespace

std::string golden_page(std::span<const GoldenFailure> failures) {
  std::string page = kHead;
  for (const GoldenFailure& failure : failures) {
    page += fmt::format("<h2>{}</h2>\n<p>{}</p>\n", failure.name, escaped(failure.verdict));
    if (failure.pictures) page += fmt::format(fmt::runtime(kViews), failure.name);
  }
  return page;
}

}  // namespace taut
