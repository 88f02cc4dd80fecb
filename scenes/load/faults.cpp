#include "scenes/load/faults.h"

#include <algorithm>
#include <set>
#include <string_view>

#include "scenes/format/format_faults.h"
#include "scenes/format/old_keys.h"
#include "scenes/reader/reader.h"

namespace taut::scenes {
namespace {

/// The part of the document that is left out once something in it is wrong: one named thing, one
/// element of a list, one key of the stage, or else a key at the top.
std::string entry_of(const std::string& key) {
  static const std::set<std::string_view> tables = {
      "paths", "characters", "bodies", "connectors", "obstacles", "touching", "stage"};
  const std::size_t dot = key.find('.');
  const std::string first = key.substr(0, dot);
  if (dot == std::string::npos || !tables.contains(first)) return first;
  const std::size_t end = key.find_first_of(".[", dot + 1);
  return key.substr(0, end);
}

const Value* value_at(const Value& from, const std::string& path) {
  for (const Value& child : from.children) {
    if (child.path == path) return &child;
    const bool within = path.starts_with(child.path) &&
                        (path[child.path.size()] == '.' || path[child.path.size()] == '[');
    if (within) return value_at(child, path);
  }
  return nullptr;
}

bool remove(Value& from, const std::string& path) {
  const auto found = std::ranges::find(from.children, path, &Value::path);
  if (found != from.children.end()) {
    from.children.erase(found);
    return true;
  }
  return std::ranges::any_of(from.children, [&](Value& child) {
    return path.starts_with(child.path) && remove(child, path);
  });
}

class Search {
 public:
  explicit Search(Document document) : document_(std::move(document)) {}

  Faults run() && {
    rename_old_keys(document_);
    FirstFaults wrong_format = format_faults(document_);
    const std::size_t count = wrong_format.count();
    for (const SceneFault& fault : std::move(wrong_format).list()) note(fault);
    if (count > found_.count()) return {std::move(found_).list(), count - FirstFaults::kMost};
    for (const std::string& entry : wrong_) leave_out(entry);
    // Each look at the rest reads it anew.
    while (!stuck_) {
      if (found_.count() >= FirstFaults::kMost) return {std::move(found_).list(), std::nullopt};
      try {
        Scene scene = read_scene(document_, true);
        if (!scene.stage) Motions(document_).check_characters();
        if (!scene.stage) check_models(document_);
        break;
      } catch (const SceneFault& fault) {
        if (!follows(fault)) note(fault);
        leave_out(entry_of(fault.place.key));
      } catch (const BadScene& fault) {
        found_.add({fault.what(), {.file = document_.file.string(), .fault = fault.what()}});
        stuck_ = true;
      }
    }
    return {std::move(found_).list()};
  }

 private:
  void note(const SceneFault& fault) {
    found_.add(fault);
    wrong_.insert(entry_of(fault.place.key));
  }

  void leave_out(std::string entry) {
    // Of a list of tables one is left out, of a list of numbers all.
    const Value* element = value_at(document_.root, entry);
    if (element && entry.ends_with(']') && element->kind != Value::Kind::table) {
      entry.resize(entry.rfind('['));
    }
    // Without a duration there is no scene, and without what cannot be left out no other look.
    if (entry.empty() || entry == "duration" || !remove(document_.root, entry)) {
      stuck_ = true;
      return;
    }
    gone_.insert(entry.substr(entry.find('.') + 1));
    const std::string table = entry.substr(0, entry.find('.'));  // perhaps misspelt
    connectors_gone_ = connectors_gone_ || !suggestion(table, {"connectors"}).empty();
    bodies_gone_ = bodies_gone_ || !suggestion(table, {"bodies"}).empty();
  }

  /// True for what is only wrong because something was left out.
  bool follows(const SceneFault& fault) const {
    const std::string& key = fault.place.key;
    const Value* value = value_at(document_.root, key);
    if (value && value->kind == Value::Kind::text && gone_.contains(value->text)) return true;
    if (connectors_gone_ && (key.ends_with(".hangs") || key.ends_with(".connector"))) return true;
    if (bodies_gone_ && key.ends_with(".body")) return true;
    // A connector as a whole: its ends have no place without what held them.
    return (connectors_gone_ || bodies_gone_) && key.starts_with("connectors.") &&
           key == entry_of(key);
  }

  Document document_;
  FirstFaults found_;
  std::set<std::string> wrong_, gone_;
  bool stuck_ = false, connectors_gone_ = false, bodies_gone_ = false;
};

}  // namespace

Faults faults_of(const std::filesystem::path& file, const std::vector<SceneChange>& changes) {
  try {
    Document document = read_document(file);
    for (const auto& [key, value] : changes) change(document, key, value);
    std::erase_if(document.root.children, [](const Value& v) { return v.name == "plan"; });
    return Search(std::move(document)).run();
  } catch (const SceneFault& fault) {
    return {{fault}};
  } catch (const BadScene& fault) {
    return {{{fault.what(), {.file = file.string(), .fault = fault.what()}}}};
  }
}

}  // namespace taut::scenes
