#include "render/picture/picture.h"

#include <fmt/format.h>
#include <libdeflate.h>
#include <png.h>

#include <memory>
#include <new>
#include <stdexcept>
#include <string_view>

#include "scenes/files/files.h"

namespace taut::picture {
namespace {

/// Puts the four bytes of a PNG's number, the highest first.
void append(std::vector<std::uint8_t>& bytes, std::uint32_t number) {
  for (const int shift : {24, 16, 8, 0}) bytes.push_back(std::uint8_t(number >> shift));
}

/// Length, name, data, and the checksum of name and data (PNG specification, section 5.3).
void append_chunk(std::vector<std::uint8_t>& png, std::string_view name,
                  std::span<const std::uint8_t> data) {
  append(png, std::uint32_t(data.size()));
  const auto from = png.size();
  png.insert(png.end(), name.begin(), name.end());
  png.insert(png.end(), data.begin(), data.end());
  append(png, libdeflate_crc32(0, &png[from], png.size() - from));
}

/// Bytes that are written before they are read.
struct Bytes {
  explicit Bytes(std::size_t n)
      : size(n), data(std::make_unique_for_overwrite<std::uint8_t[]>(n)) {}
  std::size_t size;
  std::unique_ptr<std::uint8_t[]> data;
};

/// The rows as PNG's filter 1 writes them: each byte less the one of the pixel to its left.
template <int kChannels>
Bytes filtered_rows(const Picture& picture) {
  Bytes rows(std::size_t(picture.height) * (std::size_t(picture.width) * kChannels + 1));
  std::uint8_t* out = rows.data.get();
  for (int y = 0; y < picture.height; ++y) {
    *out++ = 1;
    const std::uint8_t* in = picture.at(0, y);
    for (int k = 0; k < kChannels; ++k) *out++ = in[k];
    for (int x = 1; x < picture.width; ++x, in += 4)
      for (int k = 0; k < kChannels; ++k) *out++ = std::uint8_t(in[4 + k] - in[k]);
  }
  return rows;
}

/// A keyword and a text in UTF-8, neither packed nor translated (PNG specification, 11.3.4.5).
void append_text(std::vector<std::uint8_t>& png, const std::string& keyword,
                 const std::string& text) {
  std::vector<std::uint8_t> data(keyword.begin(), keyword.end());
  data.insert(data.end(), 5,
              0);  // the keyword's end, no packing, its method, no language, no other
  data.insert(data.end(), text.begin(), text.end());
  append_chunk(png, "iTXt", data);
}

}  // namespace

std::vector<std::uint8_t> encode_png(const Picture& picture) {
  return encode_png(picture, PngExtras{});
}

std::vector<std::uint8_t> encode_png(const Picture& picture, const PngExtras& extras) {
  const Bytes rows = extras.opacity ? filtered_rows<4>(picture) : filtered_rows<3>(picture);
  // The fastest level: the next takes half as long again to save a twentieth.
  const std::unique_ptr<libdeflate_compressor, decltype(&libdeflate_free_compressor)> compressor(
      libdeflate_alloc_compressor(1), &libdeflate_free_compressor);
  if (!compressor) throw std::bad_alloc();
  Bytes data(libdeflate_zlib_compress_bound(compressor.get(), rows.size));
  data.size = libdeflate_zlib_compress(compressor.get(), rows.data.get(), rows.size,
                                       data.data.get(), data.size);

  std::vector<std::uint8_t> header;
  append(header, std::uint32_t(picture.width));
  append(header, std::uint32_t(picture.height));
  const int kind = extras.opacity ? 6 : 2;                                         // RGBA, RGB
  for (const int byte : {8, kind, 0, 0, 0}) header.push_back(std::uint8_t(byte));  // 8 bits
  const std::uint8_t perceptual = 0;

  std::vector<std::uint8_t> png = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
  png.reserve(data.size + 128);
  append_chunk(png, "IHDR", header);
  append_chunk(png, "sRGB", {&perceptual, 1});
  for (const auto& [keyword, text] : extras.texts) append_text(png, keyword, text);
  append_chunk(png, "IDAT", {data.data.get(), data.size});
  append_chunk(png, "IEND", {});
  return png;
}

namespace {

constexpr png_uint_32 kLargest = 16384;  // pixels, as of a scene's pictures

/// Ends the reading that `begun` tells the success of.
Picture finish_reading(png_image& image, int begun, const std::string& source) {
  const auto check = [&](int ok) {
    if (ok) return;
    const std::string why = image.message;
    png_image_free(&image);
    throw scenes::bad_asset(source, why);
  };
  check(begun);
  if (image.width > kLargest || image.height > kLargest) {
    png_image_free(&image);
    throw scenes::bad_asset(source, fmt::format("{} by {} pixels, expected at most {} by {}",
                                                image.width, image.height, kLargest, kLargest));
  }
  image.format = PNG_FORMAT_RGBA;
  Picture picture(int(image.width), int(image.height));
  check(png_image_finish_read(&image, nullptr, picture.pixels.data(), 0, nullptr));
  return picture;
}

}  // namespace

Picture read_png(const std::filesystem::path& file) {
  const std::string bytes = scenes::read_bytes(file);
  return decode_png({reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()},
                    file.string());
}

Picture decode_png(std::span<const std::uint8_t> bytes, const std::string& source) {
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  return finish_reading(image, png_image_begin_read_from_memory(&image, bytes.data(), bytes.size()),
                        source);
}

}  // namespace taut::picture
