#include "station/render/png_file.h"

#include <png.h>

#include "common/base/check.h"

namespace enamel::station::render {

Status WritePng(const std::string& path, std::span<const uint8_t> rgb, int width, int height) {
  ENAMEL_CHECK(rgb.size() == static_cast<size_t>(width) * height * 3);
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  image.width = static_cast<png_uint_32>(width);
  image.height = static_cast<png_uint_32>(height);
  image.format = PNG_FORMAT_RGB;
  // A negative stride: the buffer's first row is the picture's last.
  if (png_image_write_to_file(&image, path.c_str(), 0, rgb.data(), -width * 3, nullptr) != 0)
    return Status::Ok();
  std::string reason = image.message;
  png_image_free(&image);
  return Status(Code::kStorage,
                "expected to write a screenshot to " + path + ", found: " + reason +
                    "; choose a folder that exists and is writable",
                "screenshot");
}

}  // namespace enamel::station::render
