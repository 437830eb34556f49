#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/base/result.h"

namespace enamel::station::render {

// 8-bit sRGB, (height, width, 3), first row at the bottom, as OpenGL reads it.
struct Image {
  int width = 0, height = 0;
  std::vector<uint8_t> rgb;

  Image() = default;
  Image(int w, int h)
      : width(w), height(h), rgb(static_cast<size_t>(w) * static_cast<size_t>(h) * 3) {}
  bool operator==(const Image&) const = default;
};

// Errors: kStorage with the path and the reason.
Status WritePng(const std::string& path, const Image& image);
// Errors: kNotFound where there is no such file; kInvalidInput where it is no PNG.
Result<Image> ReadPng(const std::string& path);

}  // namespace enamel::station::render
