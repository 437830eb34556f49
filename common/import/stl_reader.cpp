#include <algorithm>
#include <bit>
#include <cmath>
#include <string>

#include "common/import/mesh_formats.h"
#include "common/import/mesh_text.h"

namespace enamel::import {
namespace {

constexpr size_t kHeader = 84, kTriangle = 50;

Status Invalid(const std::string& what) { return Status(Code::kInvalidInput, what); }

std::string InBytes(uint64_t n) { return std::to_string(n) + " bytes"; }

uint32_t U32(ByteView file, size_t at) {
  uint32_t out = 0;
  for (size_t i = 0; i < 4; ++i) out |= uint32_t{file[at + i]} << (8 * i);
  return out;
}

// Corner `k` of the triangle at a byte: after the normal's 12.
dvec3 Corner(ByteView file, size_t at, size_t k) {
  dvec3 out;
  for (int i = 0; i < 3; ++i)
    out[i] = std::bit_cast<float>(U32(file, at + 12 + 12 * k + 4 * static_cast<size_t>(i)));
  return out;
}

bool LooksLikeText(std::string_view text) {
  return std::all_of(text.begin(), text.end(), [](char c) {
    return (c >= 0x20 && c != 0x7f) || c == '\t' || c == '\r' || c == '\n';
  });
}

// Whether the bytes after the last triangle are another one: then the count is wrong. Padding and
// an exporter's own data have no such numbers, or no area.
bool IsTriangle(ByteView file, size_t at) {
  if (file.size() < at + kTriangle) return false;
  const dvec3 a = Corner(file, at, 0), b = Corner(file, at, 1), c = Corner(file, at, 2);
  const dvec3 size = glm::abs(a) + glm::abs(b) + glm::abs(c);
  const double sum = size.x + size.y + size.z;
  return std::isfinite(sum) && sum < 1e9 && sum > 1e-9 &&
         glm::length(glm::cross(b - a, c - a)) > 1e-9 * sum * sum;
}

Status ReadBinary(ByteView file, uint32_t count, MeshBuilder& out) {
  const uint64_t end = kHeader + kTriangle * uint64_t{count};
  if (file.size() < end || (count == 0 && file.size() >= kHeader + kTriangle) ||
      IsTriangle(file, end)) {
    return Invalid("its header promises " + std::to_string(count) + " triangles (" + InBytes(end) +
                   "), the file has " + InBytes(file.size()) +
                   ": it is cut short or its count is wrong, export it again");
  }
  if (file.size() > end) out.Note(InBytes(file.size() - end) + " after the last triangle left out");
  for (size_t at = kHeader; at < end; at += kTriangle) {
    for (size_t k = 0; k < 3; ++k) {
      out.AddCorner(out.vertices());
      ENAMEL_RETURN_IF_ERROR(out.AddVertex(Corner(file, at, k)));
    }
    ENAMEL_RETURN_IF_ERROR(out.EndFace());
  }
  return Status::Ok();
}

std::string_view RestOfLine(std::string_view& text) {
  const std::string_view line = text.substr(0, text.find_first_of("\r\n"));
  text.remove_prefix(line.size());
  const size_t first = line.find_first_not_of(" \t");
  if (first == line.npos) return {};
  return line.substr(first, line.find_last_not_of(" \t") - first + 1);
}

class TextReader {
 public:
  explicit TextReader(MeshBuilder& out) : out_(out) {}

  Status Read(std::string_view text) {
    bool ended = false;
    for (std::string_view word; !(word = WordAcrossLines(text)).empty();) {
      if (IsWord(word, "vertex")) {
        ENAMEL_RETURN_IF_ERROR(ReadVertex(text));
      } else if (IsWord(word, "endloop")) {
        if (corners_ < 3)
          return Invalid("facet " + std::to_string(facets_ + 1) + " has " +
                         std::to_string(corners_) +
                         " corners, expected 3: the file is damaged, export it again");
        corners_ = 0;
        ++facets_;
        ENAMEL_RETURN_IF_ERROR(out_.EndFace());
      } else if (IsWord(word, "solid")) {
        out_.StartPart(RestOfLine(text), {});
        ended = false;
      } else if (IsWord(word, "endsolid") || IsEndSolid(word, text)) {
        (void)RestOfLine(text);
        ended = true;
      }
    }
    if (ended) return Status::Ok();
    return Invalid(
        "expected 'endsolid' at its end, found something else: the file is cut short, export it "
        "again");
  }

 private:
  static bool IsEndSolid(std::string_view word, std::string_view text) {
    return IsWord(word, "end") && StartsWithWord(text, "solid");
  }

  Status ReadVertex(std::string_view& text) {
    dvec3 at;
    for (int i = 0; i < 3; ++i) {
      const std::string_view word = WordAcrossLines(text);
      if (!Coordinate(word, at[i]))
        return Invalid("facet " + std::to_string(facets_ + 1) + " has the coordinate '" +
                       std::string(word.substr(0, 40)) +
                       "', which is no number: the file is damaged, export it again");
    }
    ++corners_;
    out_.AddCorner(out_.vertices());
    return out_.AddVertex(at);
  }

  MeshBuilder& out_;
  size_t facets_ = 0, corners_ = 0;
};

}  // namespace

Status ReadStl(ByteView file, MeshBuilder& out) {
  // Binary files that begin with "solid" exist. The count settles it: text never fits its own size.
  auto fits = [](ByteView bytes) {
    return bytes.size() >= kHeader &&
           bytes.size() == kHeader + kTriangle * uint64_t{U32(bytes, 80)};
  };
  if (!fits(file)) {
    if (HasUtf8Mark(file) && fits(file.subspan(kUtf8Mark))) file = file.subspan(kUtf8Mark);
  }
  Bytes converted;
  const std::string_view text = PlainText(file, converted);
  if (!fits(file) && StartsWithWord(text, "solid") && text.find('\0') == text.npos)
    return TextReader(out).Read(text);
  if (file.size() < kHeader || LooksLikeText(AsText(file))) {
    return Invalid(
        "expected an STL file: text that begins with 'solid', or at least 84 bytes of "
        "binary data, found neither");
  }
  return ReadBinary(file, U32(file, 80), out);
}

}  // namespace enamel::import
