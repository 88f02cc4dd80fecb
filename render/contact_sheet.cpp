#include "render/contact_sheet.h"

namespace taut {

Picture contact_sheet(std::span<const Picture> pictures, int columns) {
  const int width = pictures[0].width / columns, height = pictures[0].height / columns;
  const int rows = (int(pictures.size()) + columns - 1) / columns;
  Picture sheet(width * columns, height * rows);
  for (int i = 0; i < int(pictures.size()); ++i)
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x)
        for (int channel = 0; channel < 3; ++channel) {
          int sum = 0;
          for (int v = 0; v < columns; ++v)
            for (int u = 0; u < columns; ++u)
              sum += pictures[std::size_t(i)].at(x * columns + u, y * columns + v)[channel];
          const int area = columns * columns;
          sheet.at(i % columns * width + x, i / columns * height + y)[channel] =
              std::uint8_t((sum + area / 2) / area);
        }
  return sheet;
}

}  // namespace taut
