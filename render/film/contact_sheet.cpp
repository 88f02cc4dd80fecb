#include "render/film/contact_sheet.h"

#include "render/picture/paint.h"

namespace taut::film {

picture::Picture contact_sheet(std::span<const picture::Picture> pictures, int columns) {
  const int width = pictures[0].width, height = pictures[0].height;
  const int rows = (int(pictures.size()) + columns - 1) / columns;
  picture::Picture sheet(width * columns, height * rows);
  for (int i = 0; i < int(pictures.size()); ++i)
    picture::paste(pictures[std::size_t(i)], sheet, i % columns * width, i / columns * height);
  return sheet;
}

}  // namespace taut::film
