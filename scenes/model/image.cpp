#include <fmt/format.h>

#include <csetjmp>
#include <cstdio>
#include <new>
#include <stdexcept>

#include "scenes/model/formats.h"

// clang-format off
#include <jpeglib.h>  // behind <cstdio>, of which it needs FILE
#include <jerror.h>
// clang-format on
#include <png.h>

namespace taut::scenes {
namespace {

[[noreturn]] void fail(const std::string& cause) {
  throw std::runtime_error(cause);
}

void make_room(Texture& texture, std::size_t width, std::size_t height, std::size_t most) {
  constexpr std::size_t kSide = 16384;  // as much as every driver draws
  if (width == 0 || height == 0) fail("is empty");
  if (width > kSide || height > kSide || width * height > most) {
    fail(fmt::format("has {}x{} pixels, expected {} on a side and {} in all at most", width, height,
                     kSide, most));
  }
  texture.width = static_cast<std::uint32_t>(width);
  texture.height = static_cast<std::uint32_t>(height);
  texture.pixels.resize(4 * width * height);
}

Texture decode_png(std::string_view bytes, std::size_t most) {
  struct Image : png_image {
    Image() : png_image{} { version = PNG_IMAGE_VERSION; }
    ~Image() { png_image_free(this); }
  } image;
  Texture texture;
  if (!png_image_begin_read_from_memory(&image, bytes.data(), bytes.size())) fail(image.message);
  make_room(texture, image.width, image.height, most);
  image.format = PNG_FORMAT_RGBA;
  if (!png_image_finish_read(&image, nullptr, texture.pixels.data(), 0, nullptr)) {
    fail(image.message);
  }
  return texture;
}

/// Errors of libjpeg, which may not return from them.
struct JpegErrors {
  jpeg_error_mgr base;
  std::jmp_buf back;
  char cause[JMSG_LENGTH_MAX];
};

[[noreturn]] void leave(j_common_ptr common) {
  auto* errors = reinterpret_cast<JpegErrors*>(common->err);
  (*common->err->format_message)(common, errors->cause);
  std::longjmp(errors->back, 1);
}

/// Of warnings those are errors after which part of the picture is missing.
void warn(j_common_ptr common, int) {
  const int code = common->err->msg_code;
  if (code == JWRN_JPEG_EOF || code == JWRN_HUFF_BAD_CODE) leave(common);
}

/// One picture of libjpeg's. No object with a destructor lives in the functions that it may leave.
class Jpeg {
 public:
  Jpeg() {
    state_.err = jpeg_std_error(&errors_.base);
    errors_.base.error_exit = leave;
    errors_.base.emit_message = warn;
  }
  Jpeg(const Jpeg&) = delete;
  Jpeg& operator=(const Jpeg&) = delete;
  ~Jpeg() { jpeg_destroy_decompress(&state_); }

  bool read_header(const unsigned char* bytes, std::size_t size) {
    if (setjmp(errors_.back)) return false;
    jpeg_create_decompress(&state_);
    jpeg_mem_src(&state_, bytes, size);
    jpeg_read_header(&state_, TRUE);
    return true;
  }
  bool read_rows(unsigned char* pixels) {
    if (setjmp(errors_.back)) return false;
    state_.out_color_space = JCS_EXT_RGBA;
    jpeg_start_decompress(&state_);
    while (state_.output_scanline < state_.output_height) {
      JSAMPROW row = pixels + std::size_t{4} * state_.output_width * state_.output_scanline;
      jpeg_read_scanlines(&state_, &row, 1);
    }
    jpeg_finish_decompress(&state_);
    return true;
  }
  std::size_t width() const { return state_.image_width; }
  std::size_t height() const { return state_.image_height; }
  const char* cause() const { return errors_.cause; }

 private:
  jpeg_decompress_struct state_{};
  JpegErrors errors_{};
};

Texture decode_jpeg(std::string_view bytes, std::size_t most) {
  Jpeg jpeg;
  Texture texture;
  if (!jpeg.read_header(reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size())) {
    fail(jpeg.cause());
  }
  make_room(texture, jpeg.width(), jpeg.height(), most);
  if (!jpeg.read_rows(texture.pixels.data())) fail(jpeg.cause());
  return texture;
}

}  // namespace

ImageKind kind_of_image(std::string_view bytes) {
  if (bytes.starts_with("\x89PNG\r\n\x1a\n")) return ImageKind::png;
  return bytes.starts_with("\xff\xd8\xff") ? ImageKind::jpeg : ImageKind::other;
}

Texture decode_image(std::string_view bytes, std::size_t most) {
  return kind_of_image(bytes) == ImageKind::jpeg ? decode_jpeg(bytes, most)
                                                 : decode_png(bytes, most);
}

}  // namespace taut::scenes
