#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "common/base/result.h"

namespace enamel::station::render {

// Writes 8-bit RGB as PNG; `rgb` is (height, width, 3), first row at the bottom, as OpenGL reads
// it. Errors: kStorage with the path and the reason. Requires: rgb.size() == width * height * 3.
Status WritePng(const std::string& path, std::span<const uint8_t> rgb, int width, int height);

}  // namespace enamel::station::render
