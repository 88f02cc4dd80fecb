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

/// Also what a scene without a stage does not show.
void read_all(const Document& document) {
  if (read_scene(document, true).stage) return;
  Motions(document).check_characters();
  check_models(document);
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
        read_all(document_);
        break;
      } catch (const SceneFault& fault) {
        if (!follows(fault)) {
          note(fault);
          look_beside(fault);
        }
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

  /// Other faults of the same entry: its first ones hide them, unless a look without their keys
  /// shows them. A fault of what lacks such a key is none.
  void look_beside(const SceneFault& fault) {
    constexpr int kLooks = 20;
    const std::string entry = entry_of(fault.place.key);
    Document rest = document_;
    std::vector<std::string> without;
    std::set<std::string> others;  // names of entries that have faults of their own
    std::string key = fault.place.key;
    for (int look = 0; look < kLooks && found_.count() < FirstFaults::kMost; ++look) {
      const std::string wrong = entry_of(key);
      if (wrong != entry) {
        others.insert(wrong.substr(wrong.find('.') + 1));
        key = wrong;
      } else {
        without.push_back(key);
      }
      if (key == entry || !remove(rest.root, key)) return;
      try {
        read_all(rest);
        return;
      } catch (const SceneFault& other) {
        key = other.place.key;
        if (entry_of(key) != entry) continue;
        const Value* value = value_at(document_.root, key);
        const bool lacks = !value || others.contains(value->text) ||
                           other.place.fault.find("needs ") != std::string::npos ||
                           std::ranges::any_of(without, [&](const std::string& gone) {
                             return gone.starts_with(key);
                           });
        if (lacks || follows(other)) return;
        note(other);
      } catch (const BadScene&) {
        return;
      }
    }
  }

  void leave_out(std::string entry) {
    // Of a list of tables one is left out, of a list of numbers all.
    const Value* element = value_at(document_.root, entry);
    if (element && entry.ends_with(']') && element->kind != Value::Kind::table) {
      entry.resize(entry.rfind('['));
    }
    const bool lasts = document_.root.find("duration") != nullptr;
    if ((entry == "duration" || (entry.empty() && !lasts)) && !lasts_) {  // no scene without one
      change(document_, "duration", "60");
      lasts_ = true;
      return;
    }
    // Without what cannot be left out there is no other look.
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
    if (lasts_ && fault.place.fault.find("duration") != std::string::npos) return true;
    // A connector as a whole: its ends have no place without what held them.
    return (connectors_gone_ || bodies_gone_) && key.starts_with("connectors.") &&
           key == entry_of(key) && value && hangs_on_others(*value);
  }

  /// True for what names a body or a connector, and so may have no place without another.
  static bool hangs_on_others(const Value& value) {
    static const std::set<std::string_view> others = {"body", "connector", "bone"};
    return others.contains(value.name) || std::ranges::any_of(value.children, hangs_on_others);
  }

  Document document_;
  FirstFaults found_;
  std::set<std::string> wrong_, gone_;
  /// Whether it lasts as long as somebody had to choose for it.
  bool lasts_ = false;
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
