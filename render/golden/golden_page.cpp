#include "render/golden/golden_page.h"

#include <fmt/format.h>

#include "render/chart/html_page.h"
#include "render/chart/table.h"

namespace taut::golden {
namespace {

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

}  // namespace

std::string golden_page(std::span<const GoldenFailure> failures) {
  std::string body;
  for (const GoldenFailure& failure : failures) {
    body +=
        fmt::format("<h2>{}</h2>\n<p>{}</p>\n", failure.name, chart::escape_html(failure.verdict));
    if (failure.pictures) body += fmt::format(fmt::runtime(kViews), failure.name);
  }
  return chart::html_page("Golden pictures that differ", body);
}

}  // namespace taut::golden
