#include "station/render/png_file.h"

#include <png.h>
#include <unistd.h>

#include "common/base/check.h"

namespace enamel::station::render {

Status WritePng(const std::string& path, const Image& image) {
  ENAMEL_CHECK(image.rgb.size() == static_cast<size_t>(image.width) * image.height * 3);
  png_image png{};
  png.version = PNG_IMAGE_VERSION;
  png.width = static_cast<png_uint_32>(image.width);
  png.height = static_cast<png_uint_32>(image.height);
  png.format = PNG_FORMAT_RGB;
  // A negative stride: the buffer's first row is the picture's last.
  if (png_image_write_to_file(&png, path.c_str(), 0, image.rgb.data(), -image.width * 3, nullptr) !=
      0)
    return Status::Ok();
  std::string reason = png.message;
  png_image_free(&png);
  return Status(Code::kStorage,
                "expected to write a screenshot to " + path + ", found: " + reason +
                    "; choose a folder that exists and is writable",
                "screenshot");
}

Result<Image> ReadPng(const std::string& path) {
  if (access(path.c_str(), R_OK) != 0) {
    return Status(Code::kNotFound, "expected a picture in " + path + ", found none", "picture");
  }
  png_image png{};
  png.version = PNG_IMAGE_VERSION;
  if (png_image_begin_read_from_file(&png, path.c_str()) != 0) {
    png.format = PNG_FORMAT_RGB;
    Image image(static_cast<int>(png.width), static_cast<int>(png.height));
    if (png_image_finish_read(&png, nullptr, image.rgb.data(), -3 * image.width, nullptr) != 0) {
      return image;
    }
  }
  std::string reason = png.message;
  png_image_free(&png);
  return Status(Code::kInvalidInput, "expected a PNG in " + path + ", found: " + reason, "picture");
}

}  // namespace enamel::station::render
