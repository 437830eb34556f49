#include "server/storage/blobs/object_generation.h"

#include <sodium.h>

#include <charconv>
#include <cstdio>

namespace enamel::server {

int64_t NewGeneration() {
  uint64_t random = 0;
  randombytes_buf(&random, sizeof random);
  return static_cast<int64_t>(random >> 1 | 1);
}

std::string GenerationText(int64_t generation) {
  char text[17];
  std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(generation));
  return text;
}

std::optional<int64_t> ReadGeneration(std::string_view text) {
  int64_t out = 0;
  const char* const end = text.data() + text.size();
  const auto [stop, bad] = std::from_chars(text.data(), end, out, /*base=*/16);
  if (bad != std::errc() || stop != end || out <= 0 || GenerationText(out) != text) return {};
  return out;
}

}  // namespace enamel::server
