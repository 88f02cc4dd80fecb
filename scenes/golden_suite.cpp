#include "scenes/golden_suite.h"

#include <fmt/format.h>

#include <cmath>

#include "scenes/reader/format.h"
#include "scenes/reader/reader.h"

namespace taut {

namespace {

using Type = KeyFormat::Type;

// Swings stay this close to themselves from one processor to another; slack motion does not.
constexpr double kWithin = 1e-6;  // m

const TableFormat& suite_format() {
  static const TableFormat frame{
      {{.name = "scene", .type = Type::file, .meaning = "A scene with a stage.", .required = true},
       {.name = "time",
        .meaning = "When; the nearest frame is taken.",
        .unit = "s",
        .minimum = 0,
        .required = true},
       {.name = "method", .type = Type::method, .meaning = "Default: the scene's own."},
       {.name = "within",
        .meaning = "How far today's simulation may end from the kept state.",
        .unit = "m",
        .minimum = 0,
        .above = true}}};
  static const TableFormat format{{{.name = "schema_version",
                                    .meaning = "Version of this format.",
                                    .minimum = 1,
                                    .maximum = 1,
                                    .whole = true},
                                   {.name = "size",
                                    .type = Type::numbers,
                                    .meaning = "Width and height of the pictures.",
                                    .unit = "pixels",
                                    .minimum = 1,
                                    .maximum = 16384,
                                    .whole = true,
                                    .least = 2,
                                    .most = 2},
                                   {.name = "samples",
                                    .meaning = "Samples per pixel.",
                                    .minimum = 1,
                                    .maximum = 64,
                                    .whole = true},
                                   {.name = "frames",
                                    .type = Type::named,
                                    .meaning = "The pictures, by their names.",
                                    .required = true,
                                    .table = &frame}}};
  return format;
}

GoldenFrame read_frame(const Document& document, const Value& value) {
  const Value& file = *value.find("scene");
  GoldenFrame frame;
  frame.name = value.name;
  frame.source = fmt::format("{}:{}", document.file.string(), value.key_place.line);
  frame.scene = find_file(document, file);
  const Scene scene = load_scene(frame.scene, false);
  const Value& time = *value.find("time");
  frame.frame = static_cast<int>(std::lround(time.number * scene.fps));
  if (frame.frame >= scene.frames())
    document.mismatch(time, fmt::format("a time before the scene's end, {} s", scene.duration));
  const Value* method = value.find("method");
  frame.method = method ? read_method(document, method, scene.fps) : scene.method;
  frame.within = number_or(value, "within", kWithin);
  return frame;
}

}  // namespace

GoldenSuite load_golden_suite(const std::filesystem::path& folder) {
  const Document document = read_document(folder / "golden.toml");
  check_format(document, suite_format());
  GoldenSuite suite;
  suite.folder = folder;
  if (const Value* size = document.root.find("size")) {
    suite.width = static_cast<int>(size->children[0].number);
    suite.height = static_cast<int>(size->children[1].number);
  }
  suite.samples = static_cast<int>(number_or(document.root, "samples", suite.samples));
  for (const Value& frame : document.root.find("frames")->children)
    suite.frames.push_back(read_frame(document, frame));
  return suite;
}

}  // namespace taut
