#include "scenes/load/scene_files.h"

#include "scenes/files/error.h"
#include "scenes/format/format.h"
#include "scenes/reader/common.h"

namespace taut::scenes {
namespace {

void add_named(const Document& document, const Value& table, const TableFormat& format,
               std::vector<std::filesystem::path>& files) {
  using Kind = KeyFormat::Type;
  const auto add = [&](const Value& value) {
    if (value.kind != Value::Kind::text) return;
    try {
      files.push_back(find_file(document, value));
    } catch (const BadScene&) {  // which is told when the scene is read
    }
  };
  for (const Value& member : table.children) {
    const KeyFormat* key = format.find(member.name);
    if (!key) continue;
    if (key->type == Kind::file) add(member);
    if (key->type == Kind::table) add_named(document, member, *key->table, files);
    for (const Value& element : member.children) {
      if (key->type == Kind::files) add(element);
      if (key->type == Kind::named || key->type == Kind::tables)
        add_named(document, element, *key->table, files);
    }
  }
}

}  // namespace

std::vector<std::filesystem::path> scene_files(const std::filesystem::path& scene) {
  std::vector<std::filesystem::path> files = {scene};
  try {
    const Document document = read_document(scene);
    if (!document.base.empty()) files.push_back(document.base);
    add_named(document, document.root, scene_format(), files);
  } catch (const BadScene&) {  // which is told when the scene is read
  }
  return files;
}

}  // namespace taut::scenes
