#include "render/caption.h"

#include <algorithm>
#include <cmath>

namespace taut {

void draw_captions(Picture& picture, Font& font, std::span<const Caption> captions, double time) {
  constexpr double kFade = 0.2;  // s
  const double size = std::max(0.026 * picture.height, 9.0);
  const double x = 0.05 * picture.width, y = 0.93 * picture.height;
  for (const Caption& caption : captions) {
    const double since = time - caption.from, left = caption.until - time;
    if (since < 0 || left <= 0) continue;
    const double opacity = std::min({1.0, (since + 1e-3) / kFade, left / kFade});
    const double shadow = std::max(1.0, size / 18);
    font.draw(picture, caption.text, x + shadow, y + shadow, size, {0, 0, 0}, 0.55 * opacity);
    font.draw(picture, caption.text, x, y, size, {248, 245, 238}, 0.95 * opacity);
  }
}

}  // namespace taut
