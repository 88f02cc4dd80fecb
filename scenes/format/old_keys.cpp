#include "scenes/format/old_keys.h"

#include <fmt/format.h>

#include <algorithm>

#include "scenes/format/format.h"

namespace taut::scenes {
namespace {

class Renaming {
 public:
  explicit Renaming(const Document& document) : document_(document) {}

  void go_through(Value& table, const TableFormat& format) {
    for (Value& member : table.children) {
      const auto now = std::ranges::find_if(format.keys, [&](const KeyFormat& key) {
        return !key.formerly.empty() && key.formerly == member.name && !table.find(key.name);
      });
      if (now != format.keys.end()) {
        tell(member, now->name);
        member.name = now->name;
      }
      const KeyFormat* key = format.find(member.name);
      if (!key || !key->table) continue;
      if (key->type == KeyFormat::Type::table) {
        go_through(member, *key->table);
      } else {
        for (Value& element : member.children) go_through(element, *key->table);
      }
    }
  }

  std::vector<std::string> told;

 private:
  void tell(const Value& key, std::string_view now) {
    const std::string file = (key.inherited ? document_.base : document_.file).string();
    const std::string place =
        key.place.line > 0 ? fmt::format("{}:{}:{}", file, key.key_place.line, key.key_place.column)
                           : file;
    told.push_back(fmt::format("{}: {} is called {} now", place, key.path, now));
  }

  const Document& document_;
};

}  // namespace

std::vector<std::string> rename_old_keys(Document& document) {
  Renaming renaming(document);
  renaming.go_through(document.root, scene_format());
  return renaming.told;
}

}  // namespace taut::scenes
