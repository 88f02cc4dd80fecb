#include "render/export/zip.h"

#include <libdeflate.h>

#include "render/export/little_endian.h"

namespace taut::exporting {
namespace {

using U16 = std::uint16_t;
using U32 = std::uint32_t;
using U64 = std::uint64_t;

constexpr U16 kVersion = 45;       // with sizes of 64 bits
constexpr U16 kFirstDay = 0x0021;  // 1 January 1980
constexpr U32 kElsewhere = 0xffffffff;
constexpr U16 kElsewhere16 = 0xffff;

}  // namespace

void Zip::put(std::string_view bytes) {
  write_(bytes);
  written_ += bytes.size();
}

void Zip::add(const std::string& name, const std::vector<std::string_view>& pieces) {
  U64 size = 0;
  U32 sum = 0;
  for (const std::string_view piece : pieces) {
    size += piece.size();
    sum = libdeflate_crc32(sum, piece.data(), piece.size());
  }
  const U64 offset = written_;
  // Flags (names in UTF-8), stored, time, date, sum, sizes in the extra field.
  const std::string common = little_endian(kVersion, U16(0x0800), U16(0), U16(0), kFirstDay, sum,
                                           kElsewhere, kElsewhere, U16(name.size()));
  put(little_endian(U32(0x04034b50)) + common + little_endian(U16(20)) + name +
      little_endian(U16(1), U16(16), size, size));
  for (const std::string_view piece : pieces) put(piece);
  list_ += little_endian(U32(0x02014b50), kVersion) + common +
           little_endian(U16(28), U16(0), U16(0), U16(0), U32(0), kElsewhere) + name +
           little_endian(U16(1), U16(24), size, size, offset);
  ++files_;
}

void Zip::finish() {
  const U64 list = written_, end = written_ + list_.size();
  put(list_);
  put(little_endian(U32(0x06064b50), U64(44), kVersion, kVersion, U32(0), U32(0), files_, files_,
                    U64(list_.size()), list));
  put(little_endian(U32(0x07064b50), U32(0), end, U32(1)));
  put(little_endian(U32(0x06054b50), U16(0), U16(0), kElsewhere16, kElsewhere16, kElsewhere,
                    kElsewhere, U16(0)));
}

}  // namespace taut::exporting
