#include <string>

#include "common/import/mesh_formats.h"
#include "common/import/mesh_text.h"

namespace enamel::import {
namespace {

Status Invalid(const std::string& what) { return Status(Code::kInvalidInput, what); }

std::string_view Trimmed(std::string_view text) {
  const size_t first = text.find_first_not_of(" \t");
  if (first == text.npos) return {};
  return text.substr(first, text.find_last_not_of(" \t") - first + 1);
}

class ObjReader {
 public:
  ObjReader(std::string_view text, MeshBuilder& out) : lines_(text), out_(out) {}

  Status Read() {
    while (NextLine()) {
      const std::string_view word = Word(line_);
      if (word == "v") {
        ENAMEL_RETURN_IF_ERROR(ReadVertex());
      } else if (word == "f" || word == "fo") {
        ENAMEL_RETURN_IF_ERROR(ReadFace());
      } else if (word == "o" || word == "g") {
        name_ = Trimmed(line_);
        out_.StartPart(name_, material_);
      } else if (word == "usemtl") {
        material_ = Trimmed(line_);
        out_.StartPart(name_, material_);
      }
    }
    return Status::Ok();
  }

 private:
  // A line that ends with a backslash goes on in the next.
  bool NextLine() {
    if (!lines_.Next(line_)) return false;
    ++number_;
    if (!line_.ends_with('\\')) return true;
    joined_.assign(line_);
    while (joined_.ends_with('\\') && lines_.Next(line_)) {
      ++number_;
      joined_.back() = ' ';
      joined_ += line_;
    }
    line_ = joined_;
    return true;
  }

  Status ReadVertex() {
    dvec3 at;
    for (int i = 0; i < 3; ++i) {
      const std::string_view word = Word(line_);
      if (!Coordinate(word, at[i]))
        return Invalid("line " + std::to_string(number_) + ": expected three coordinates, found '" +
                       std::string(word.substr(0, 40)) + "': the file is damaged, export it again");
    }
    return out_.AddVertex(at);
  }

  Status ReadFace() {
    size_t corners = 0;
    for (std::string_view word; !(word = Word(line_)).empty(); ++corners) {
      if (word.front() == '#') break;
      // Texture and normal follow the first slash.
      int64_t index = 0;
      const std::string_view vertex = word.substr(0, word.find('/'));
      // Below 0: counted backwards from the last vertex so far.
      const auto known = static_cast<int64_t>(out_.vertices());
      if (!SignedNumber(vertex, index) || index == 0 || index < -known)
        return Invalid("line " + std::to_string(number_) + ": a face names vertex '" +
                       std::string(word.substr(0, 40)) + "': the file is damaged, export it again");
      out_.AddCorner(static_cast<uint64_t>(index > 0 ? index - 1 : known + index));
    }
    if (corners < 3 && !lines_.whole())
      return Invalid("its last line is half a face: the file is cut short, export it again");
    return out_.EndFace();
  }

  Lines lines_;
  std::string_view line_;
  std::string joined_, name_, material_;
  uint64_t number_ = 0;
  MeshBuilder& out_;
};

}  // namespace

Status ReadObj(ByteView file, MeshBuilder& out) {
  Bytes converted;
  return ObjReader(PlainText(file, converted), out).Read();
}

}  // namespace enamel::import
