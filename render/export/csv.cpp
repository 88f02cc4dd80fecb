#include "render/export/csv.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <limits>
#include <nlohmann/json.hpp>
#include <utility>

#include "render/export/npz.h"

namespace taut::exporting {
namespace {

class CsvWriter final : public FrameWriter {
 public:
  CsvWriter(const scenes::Scene& scene, WriteBytes write) : write_(std::move(write)) {
    write_(csv_header(scene) + '\n');
  }
  void add(const ExportState& state) override { write_(csv_row(state.state) + '\n'); }
  void finish() override {}

 private:
  WriteBytes write_;
};

}  // namespace

std::string csv_header(const scenes::Scene& scene) {
  const World world = divided(scene.world, scene.timeline);
  std::string line = "t";
  for (const Connector& connector : world.connectors) {
    for (std::size_t i = 0; i < connector.particles(); ++i) {
      for (const char axis : {'x', 'y', 'z'}) {
        line += fmt::format(",{}.{}.{}", connector.name, i, axis);
      }
    }
  }
  for (const Body& body : world.bodies) {
    for (const char* part : {"x", "y", "z", "qw", "qx", "qy", "qz"}) {
      line += fmt::format(",{}.{}", body.name, part);
    }
  }
  for (const Pulley& pulley : world.pulleys) line += fmt::format(",{}.passed", pulley.name);
  return line;
}

std::string csv_row(const Snapshot& state) {
  std::string line = fmt::format("{:.17g}", state.time);
  const auto add = [&line](double number) {
    fmt::format_to(std::back_inserter(line), ",{:.17g}", number);
  };
  for (const auto& particles : state.connectors) {
    for (const Vec3& particle : particles) std::ranges::for_each(particle, add);
  }
  for (const Pose& frame : state.bodies) {
    const Quat& q = frame.rotation;
    std::ranges::for_each(frame.position, add);
    for (const double part : {q.w(), q.x(), q.y(), q.z()}) add(part);
  }
  std::ranges::for_each(state.passed, add);
  return line;
}

std::unique_ptr<FrameWriter> csv_writer(const scenes::Scene& scene, WriteBytes write) {
  return std::make_unique<CsvWriter>(scene, std::move(write));
}

namespace {

using Json = nlohmann::ordered_json;

std::string holder(const World& world, const Forces::Hold& hold) {
  const auto& holds = world.connectors[hold.connector].holds;
  const auto at = std::ranges::find(holds, hold.particle, &Hold::particle);
  if (at == holds.end()) return "";
  switch (at->to.kind) {
    case Attachment::Kind::fixed:
      return "fixed";
    case Attachment::Kind::path:
      return "path";
    case Attachment::Kind::body:
      return world.bodies[at->to.body].name;
  }
  return "";
}

/// Of UTF-8; what is none becomes U+FFFD.
std::u32string code_points(std::string_view text) {
  std::u32string found;
  for (std::size_t i = 0; i < text.size();) {
    const auto first = static_cast<unsigned char>(text[i]);
    const int more = first < 0x80    ? 0
                     : first >= 0xf0 ? 3
                     : first >= 0xe0 ? 2
                     : first >= 0xc0 ? 1
                                     : -1;
    auto code = static_cast<char32_t>(more > 0 ? first & (0x3f >> more) : first);
    bool whole = more >= 0;
    std::size_t next = i + 1;
    for (int k = 0; k < more; ++k, ++next) {
      whole = whole && next < text.size() && (text[next] & 0xc0) == 0x80;
      if (!whole) break;
      code = code << 6 | static_cast<char32_t>(text[next] & 0x3f);
    }
    found += whole ? code : U'\ufffd';
    i = whole ? next : i + 1;
  }
  return found;
}

class ForceCsvWriter final : public ForceWriter {
 public:
  explicit ForceCsvWriter(WriteBytes write) : write_(std::move(write)) {
    write_("t,what,of,part,with,with_part,x,y,z,fx,fy,fz,size\n");
  }

 private:
  static std::string cells(const std::optional<Vec3>& v) {
    return v ? fmt::format("{:.17g},{:.17g},{:.17g}", v->x(), v->y(), v->z()) : ",,";
  }
  void add(const Row& row) override {
    write_(fmt::format("{:.17g},{},{},{},{},{},{},{},{}\n", row.time, row.what, row.of.name,
                       row.of.part, row.with.name, row.with.part, cells(row.place),
                       cells(row.force), row.size ? fmt::format("{:.17g}", *row.size) : ""));
  }

  WriteBytes write_;
};

class ForceJsonWriter final : public ForceWriter {
 public:
  explicit ForceJsonWriter(WriteBytes write) : write_(std::move(write)) {}
  void finish() override { write_(any_ ? "\n]\n" : "[]\n"); }

 private:
  void add(const Row& row) override {
    Json json = {{"t", row.time},       {"what", row.what},      {"of", row.of.name},
                 {"part", row.of.part}, {"with", row.with.name}, {"with_part", row.with.part}};
    const auto add_vector = [&](const std::optional<Vec3>& v, const char* const(&keys)[3]) {
      for (int i = 0; i < 3; ++i) json[keys[i]] = v ? Json((*v)[i]) : nullptr;
    };
    add_vector(row.place, {"x", "y", "z"});
    add_vector(row.force, {"fx", "fy", "fz"});
    json["size"] = row.size ? Json(*row.size) : nullptr;
    write_((std::exchange(any_, true) ? ",\n" : "[\n") +
           json.dump(-1, ' ', false, Json::error_handler_t::replace));
  }

  WriteBytes write_;
  bool any_ = false;
};

class NpzForceWriter final : public ForceWriter {
 public:
  explicit NpzForceWriter(WriteBytes write) : zip_(std::move(write)) {}

  void finish() override {
    add_numbers("t", times_, 1);
    const char* names[] = {"what", "of", "part", "with", "with_part"};
    for (std::size_t i = 0; i < std::size(names); ++i) add_texts(names[i], texts_[i]);
    add_numbers("place", places_, 3);
    add_numbers("force", forces_, 3);
    add_numbers("size", sizes_, 1);
    zip_.finish();
  }

 private:
  void add(const Row& row) override {
    constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
    times_.push_back(row.time);
    const std::string_view cells[] = {row.what, row.of.name, row.of.part, row.with.name,
                                      row.with.part};
    for (std::size_t i = 0; i < std::size(cells); ++i) texts_[i].emplace_back(cells[i]);
    for (const double c : row.place.value_or(Vec3::Constant(kNone))) places_.push_back(c);
    for (const double c : row.force.value_or(Vec3::Constant(kNone))) forces_.push_back(c);
    sizes_.push_back(row.size.value_or(kNone));
  }

  void add_numbers(const std::string& name, const std::vector<double>& numbers,
                   std::size_t columns) {
    std::vector<std::size_t> shape = {numbers.size() / columns};
    if (columns > 1) shape.push_back(columns);
    zip_.add(name + ".npy", {npy_header("<f8", shape), bytes_of(std::span<const double>(numbers))});
  }

  /// numpy's texts: code points of 32 bits, all as long as the longest.
  void add_texts(const std::string& name, const std::vector<std::string>& texts) {
    std::vector<std::u32string> wide;
    std::size_t most = 1;
    for (const std::string& text : texts) {
      wide.push_back(code_points(text));
      most = std::max(most, wide.back().size());
    }
    std::u32string all;
    for (std::u32string& text : wide) {
      text.resize(most);
      all += text;
    }
    zip_.add(name + ".npy", {npy_header(fmt::format("<U{}", most), {texts.size()}),
                             bytes_of(std::span<const char32_t>(all))});
  }

  Zip zip_;
  std::vector<double> times_, places_, forces_, sizes_;
  std::array<std::vector<std::string>, 5> texts_;
};

}  // namespace

void ForceWriter::add(const World& world, const Forces& forces, std::span<const Event> events) {
  using Kind = Event::Kind;
  for (const Event& event : events) {
    Row row{.time = event.time, .what = kind_name(event.kind)};
    if (event.of_contact) {
      row.of = named(world, event.one);
      row.with = named(world, event.other);
      row.place = event.place;
    } else {
      row.of = {world.connectors[event.connector].name, std::to_string(event.span)};
    }
    if (event.kind == Kind::impulse || event.kind == Kind::hit || event.kind == Kind::breaks) {
      row.size = event.size;
    }
    add(row);
  }
  const auto put = [&](const char* what, const Named& of, const Named& with, const Vec3& place,
                       const Vec3& force, double size) {
    add({forces.time, what, of, with, place, force, size});
  };
  for (const Forces::Link& at : forces.links) {
    put("tension", named(world, at), {}, at.place, at.tension * at.direction, at.tension);
  }
  for (const Forces::Hold& at : forces.holds) {
    put("hold", named(world, at), {holder(world, at), ""}, at.place, at.force, at.force.norm());
    if (at.moment.isZero(0)) continue;
    put("moment", named(world, at), {holder(world, at), ""}, at.place, at.moment, at.moment.norm());
  }
  for (const Forces::Contact& at : forces.contacts) {
    put("contact", named(world, at.one), named(world, at.other), at.place, at.force,
        at.force.norm());
  }
}

std::unique_ptr<ForceWriter> force_writer(std::string_view file, WriteBytes write) {
  if (file.ends_with(".npz")) return std::make_unique<NpzForceWriter>(std::move(write));
  if (file.ends_with(".json")) return std::make_unique<ForceJsonWriter>(std::move(write));
  return std::make_unique<ForceCsvWriter>(std::move(write));
}

}  // namespace taut::exporting
