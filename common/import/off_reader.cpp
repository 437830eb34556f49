#include <string>

#include "common/import/mesh_formats.h"
#include "common/import/mesh_text.h"

namespace enamel::import {
namespace {

Status Invalid(const std::string& what) { return Status(Code::kInvalidInput, what); }

// Numbers and words of a text, comments from '#' to the line's end left out.
class Words {
 public:
  explicit Words(std::string_view text) : lines_(text) {}
  std::string_view Next() {
    for (;;) {
      if (const std::string_view word = Word(line_); !word.empty()) return word;
      if (!lines_.Next(line_)) return {};
      line_ = line_.substr(0, Comment(line_));
    }
  }
  void SkipLine() { line_ = {}; }

 private:
  // '#' within a word is none: 1.#IND.
  static size_t Comment(std::string_view line) {
    for (size_t at = line.find('#'); at != line.npos; at = line.find('#', at + 1)) {
      if (at == 0 || line[at - 1] != '.') return at;
    }
    return line.npos;
  }
  Lines lines_;
  std::string_view line_;
};

Status TooShort(const char* what, uint64_t promised, uint64_t found) {
  return Invalid("it promises " + std::to_string(promised) + " " + what + ", the file holds " +
                 std::to_string(found) +
                 ": it is cut short or its counts are wrong, export it again");
}

Status ReadVertices(Words& words, uint64_t count, MeshBuilder& out) {
  for (uint64_t i = 0; i < count; ++i) {
    dvec3 at;
    for (int axis = 0; axis < 3; ++axis) {
      const std::string_view word = words.Next();
      if (word.empty()) return TooShort("vertices", count, i);
      if (!Coordinate(word, at[axis]))
        return Invalid("vertex " + std::to_string(i) + " has a coordinate that is no number");
    }
    words.SkipLine();  // normals or colours
    ENAMEL_RETURN_IF_ERROR(out.AddVertex(at));
  }
  return Status::Ok();
}

Status ReadFaces(Words& words, uint64_t count, uint64_t vertices, MeshBuilder& out) {
  for (uint64_t i = 0; i < count; ++i) {
    uint64_t corners = 0, index = 0;
    if (!Number(words.Next(), corners)) return TooShort("faces", count, i);
    if (corners == 0) return Invalid("face " + std::to_string(i) + " has no corners");
    for (uint64_t k = 0; k < corners; ++k) {
      if (!Number(words.Next(), index)) return TooShort("faces", count, i);
      if (index >= vertices)
        return Invalid("a face names vertex " + std::to_string(index) + " of " +
                       std::to_string(vertices));
      out.AddCorner(index);
    }
    ENAMEL_RETURN_IF_ERROR(out.EndFace());
    words.SkipLine();
  }
  return Status::Ok();
}

}  // namespace

Status ReadOff(ByteView file, MeshBuilder& out) {
  Bytes converted;
  Words words(PlainText(file, converted));
  std::string_view word = words.Next();
  // "OFF", with letters before it for more than coordinates; the first count may follow at once.
  if (const size_t off = word.find("OFF"); off != std::string_view::npos) {
    word.remove_prefix(off + 3);
    if (word.empty()) word = words.Next();
  }
  if (IsWord(word, "binary"))
    return Invalid("expected an OFF file of text, found a binary one: export it as STL or PLY");
  uint64_t vertices = 0, faces = 0, edges = 0;
  if (!Number(word, vertices) || !Number(words.Next(), faces) || !Number(words.Next(), edges))
    return Invalid("expected 'OFF' and three counts at its beginning");
  if (faces > mesh::kMaxTriangles) {
    return Status(Code::kTooLarge, std::to_string(faces) + " triangles, expected at most " +
                                       std::to_string(mesh::kMaxTriangles) +
                                       ": reduce the mesh in a mesh program (a crown needs no more "
                                       "than 200000)");
  }
  // Each takes a byte at least.
  if (vertices > file.size()) return TooShort("vertices", vertices, 0);
  ENAMEL_RETURN_IF_ERROR(ReadVertices(words, vertices, out));
  return ReadFaces(words, faces, vertices, out);
}

}  // namespace enamel::import
