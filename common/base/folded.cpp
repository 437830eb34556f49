#include "common/base/folded.h"

#include <algorithm>
#include <cstdint>
#include <iterator>

#include "common/base/utf8.h"

namespace enamel {
namespace {

enum How : uint8_t {
  kSame,   // all of them become `to`
  kShift,  // the first becomes `to`, the next one the character after that, …
  kPairs,  // every other one, from the first on, becomes the one after it
};
struct Run {
  uint32_t first, last;
  How how;
  const char* to;
};
// In rising order. folded_table.py writes it.
constexpr Run kRuns[] = {
#include "common/base/folded_table.inc"
};

void AppendCodePoint(uint32_t code, std::string& out) {
  const auto tail = [&](int shift) { return static_cast<char>(0x80 | ((code >> shift) & 0x3f)); };
  if (code < 0x80) {
    out += static_cast<char>(code);
  } else if (code < 0x800) {
    out += static_cast<char>(0xc0 | (code >> 6));
    out += tail(0);
  } else {
    out += static_cast<char>(0xe0 | (code >> 12));
    out += tail(6);
    out += tail(0);
  }
}

// Appends what the character becomes; false: it stays.
bool AppendFolded(uint32_t code, std::string& out) {
  const auto* run = std::ranges::upper_bound(kRuns, code, {}, &Run::first);
  if (run == std::begin(kRuns) || code > (--run)->last) return false;
  switch (run->how) {
    case kSame:
      out += run->to;
      return true;
    case kShift: {
      std::string_view to = run->to;
      AppendCodePoint(*NextCodePoint(to) + (code - run->first), out);
      return true;
    }
    case kPairs:
      if ((code - run->first) % 2 != 0) return false;
      AppendCodePoint(code + 1, out);
      return true;
  }
  return false;
}

}  // namespace

std::string Folded(std::string_view text) {
  std::string out;
  while (!text.empty()) {
    const char first = text.front();
    std::string_view rest = text;
    const std::optional<uint32_t> code = NextCodePoint(rest);
    const size_t size = code ? text.size() - rest.size() : 1;
    if (first >= 'A' && first <= 'Z') {
      out += static_cast<char>(first - 'A' + 'a');
    } else if (!code || *code < 0x80 || !AppendFolded(*code, out)) {
      out += text.substr(0, size);
    }
    text.remove_prefix(size);
  }
  return out;
}

}  // namespace enamel
