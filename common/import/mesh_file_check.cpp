#include "common/import/mesh_file_check.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <string>
#include <vector>

#include "common/mesh/triangles.h"

namespace enamel::import {
namespace {

constexpr std::string_view kAgain = "export it again";
constexpr size_t kStlHeader = 84, kStlTriangle = 50;

Status Invalid(const std::string& what) { return Status(Code::kInvalidInput, what); }

std::string InBytes(uint64_t n) { return std::to_string(n) + " bytes"; }

Status TooMany(uint64_t triangles) {
  return Status(Code::kTooLarge, std::to_string(triangles) + " triangles, expected at most " +
                                     std::to_string(mesh::kMaxTriangles) +
                                     ": reduce the mesh in a mesh program (a crown needs no more "
                                     "than 200000)");
}

// Lines of a text, without their ends ("\n", "\r\n" or "\r").
class Lines {
 public:
  explicit Lines(std::string_view text) : rest_(text) {}
  bool Next(std::string_view& line) {
    if (rest_.empty()) return false;
    const size_t end = rest_.find_first_of("\r\n");
    line = rest_.substr(0, end);
    if (end == std::string_view::npos) {
      rest_ = {};
      whole_ = false;
      return true;
    }
    const bool pair = rest_.substr(end, 2) == "\r\n";
    rest_.remove_prefix(end + (pair ? 2 : 1));
    return true;
  }
  std::string_view rest() const { return rest_; }
  bool whole() const { return whole_; }  // the last line given had an end

 private:
  std::string_view rest_;
  bool whole_ = true;
};

// The next word of a line, empty at its end.
std::string_view Word(std::string_view& line) {
  const size_t first = line.find_first_not_of(" \t");
  if (first == std::string_view::npos) return line = {};
  line.remove_prefix(first);
  const std::string_view word = line.substr(0, line.find_first_of(" \t"));
  line.remove_prefix(word.size());
  return word;
}

bool Number(std::string_view word, uint64_t& value) {
  auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  return error == std::errc() && end == word.data() + word.size();
}

bool IsCoordinate(std::string_view word) {
  if (word.starts_with('+')) word.remove_prefix(1);
  double value = 0;
  auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  return error == std::errc() && end == word.data() + word.size();
}

bool StartsWithWord(std::string_view text, std::string_view word) {
  text.remove_prefix(std::min(text.find_first_not_of(" \t\r\n"), text.size()));
  return text.size() >= word.size() &&
         std::equal(word.begin(), word.end(), text.begin(),
                    [](char w, char t) { return w == (t >= 'A' && t <= 'Z' ? t - 'A' + 'a' : t); });
}

bool LooksLikeText(std::string_view text) {
  return std::all_of(text.begin(), text.end(), [](char c) {
    return (c >= 0x20 && c != 0x7f) || c == '\t' || c == '\r' || c == '\n';
  });
}

Status CheckStlText(std::string_view text) {
  // The last word "endsolid" may be followed by a name of any length, on the last line.
  const size_t last_line = text.find_last_not_of(" \t\r\n");
  const size_t line_end = text.find_last_of("\r\n", last_line);
  const std::string_view last = text.substr(line_end == std::string_view::npos ? 0 : line_end + 1);
  if (StartsWithWord(last, "endsolid") || StartsWithWord(last, "end solid")) return Status::Ok();
  return Invalid("expected 'endsolid' at its end, found something else: the file is cut short, " +
                 std::string(kAgain));
}

Status CheckStl(ByteView file) {
  const std::string_view text = AsText(file);
  uint64_t count = 0;
  if (file.size() >= kStlHeader) {
    for (size_t i = 0; i < 4; ++i) count |= uint64_t{file[80 + i]} << (8 * i);
  }
  // Binary files that begin with "solid" exist. The count settles it: text never fits its own size.
  const bool fits = file.size() >= kStlHeader && file.size() == kStlHeader + kStlTriangle * count;
  const bool is_text = StartsWithWord(text, "solid") && text.find('\0') == std::string_view::npos;
  if (!fits && is_text) return CheckStlText(text);
  if (file.size() < kStlHeader || LooksLikeText(text)) {
    return Invalid(
        "expected an STL file: text that begins with 'solid', or at least 84 bytes of "
        "binary data, found neither");
  }
  if (fits) return count > mesh::kMaxTriangles ? TooMany(count) : Status::Ok();
  return Invalid("its header promises " + std::to_string(count) + " triangles (" +
                 InBytes(kStlHeader + kStlTriangle * count) + "), the file has " +
                 InBytes(file.size()) + ": it is cut short or its count is wrong, " +
                 std::string(kAgain));
}

struct PlyType {
  std::string_view name, other;
  size_t size;
};
constexpr std::array<PlyType, 8> kPlyTypes = {{{"char", "int8", 1},
                                               {"uchar", "uint8", 1},
                                               {"short", "int16", 2},
                                               {"ushort", "uint16", 2},
                                               {"int", "int32", 4},
                                               {"uint", "uint32", 4},
                                               {"float", "float32", 4},
                                               {"double", "float64", 8}}};

size_t PlySize(std::string_view type) {
  for (const PlyType& t : kPlyTypes) {
    if (type == t.name || type == t.other) return t.size;
  }
  return 0;
}

struct PlyProperty {
  size_t list_size = 0;  // of the number that counts a list's items; 0: no list
  size_t size = 0;
};

struct PlyElement {
  std::string_view name;
  uint64_t count = 0;
  std::vector<PlyProperty> properties;
};

enum class PlyFormat { kText, kLittle, kBig };

struct PlyHeader {
  PlyFormat format = PlyFormat::kText;
  std::vector<PlyElement> elements;
};

Status ReadPlyProperty(std::string_view line, PlyElement& element) {
  PlyProperty property;
  std::string_view type = Word(line);
  if (type == "list") {
    property.list_size = PlySize(Word(line));
    type = property.list_size > 0 && property.list_size <= 4 ? Word(line) : std::string_view();
  }
  property.size = PlySize(type);
  if (property.size == 0) return Invalid("its header has a property of no known type");
  element.properties.push_back(property);
  return Status::Ok();
}

Result<PlyHeader> ReadPlyHeader(Lines& lines) {
  // A header is some ten lines; without a bound a file of short lines would be a header of all of
  // it.
  constexpr int kMostLines = 10'000;
  PlyHeader header;
  std::string_view line;
  if (!lines.Next(line) || Word(line) != "ply") return Invalid("expected a first line 'ply'");
  for (int i = 0; i < kMostLines && lines.Next(line); ++i) {
    const std::string_view word = Word(line);
    if (word == "end_header") return header;
    if (word == "format") {
      const std::string_view format = Word(line);
      header.format = format == "binary_big_endian"      ? PlyFormat::kBig
                      : format == "binary_little_endian" ? PlyFormat::kLittle
                                                         : PlyFormat::kText;
    } else if (word == "element") {
      PlyElement element;
      element.name = Word(line);
      if (!Number(Word(line), element.count))
        return Invalid("its header does not say how many of '" +
                       std::string(element.name.substr(0, 40)) + "' there are");
      header.elements.push_back(std::move(element));
    } else if (word == "property") {
      if (header.elements.empty()) return Invalid("its header has a property of nothing");
      ENAMEL_RETURN_IF_ERROR(ReadPlyProperty(line, header.elements.back()));
    }
  }
  return Invalid("its header has no end ('end_header'): the file is cut short, " +
                 std::string(kAgain));
}

// Steps over an element in binary data; false when the data ends before it.
bool SkipPlyElement(const PlyElement& element, PlyFormat format, ByteView& data) {
  for (const PlyProperty& p : element.properties) {
    uint64_t items = 1;
    if (p.list_size > 0) {
      if (data.size() < p.list_size) return false;
      items = 0;
      for (size_t k = 0; k < p.list_size; ++k) {
        const size_t at = format == PlyFormat::kLittle ? p.list_size - 1 - k : k;
        items = items << 8 | data[at];
      }
      data = data.subspan(p.list_size);
    }
    // Divided, since items * size may overflow.
    if (data.size() / p.size < items) return false;
    data = data.subspan(items * p.size);
  }
  return true;
}

Status PlyTooShort(const PlyElement& element, uint64_t found) {
  return Invalid("its header promises " + std::to_string(element.count) + " of '" +
                 std::string(element.name.substr(0, 40)) + "', the file holds " +
                 std::to_string(found) + ": it is cut short or its counts are wrong, " +
                 std::string(kAgain));
}

Status CheckPlyBinary(const PlyHeader& header, ByteView data) {
  constexpr size_t kSlack = 16;  // some writers end with a line end
  for (const PlyElement& element : header.elements) {
    // Takes no bytes, so its count is bounded by nothing: it must not be counted through.
    if (element.properties.empty()) continue;
    for (uint64_t i = 0; i < element.count; ++i) {
      if (!SkipPlyElement(element, header.format, data)) return PlyTooShort(element, i);
    }
  }
  if (data.size() <= kSlack) return Status::Ok();
  return Invalid(InBytes(data.size()) +
                 " follow the last element that its header promises: its counts are wrong, " +
                 std::string(kAgain));
}

Status CheckPlyText(const PlyHeader& header, Lines lines) {
  std::string_view line;
  for (const PlyElement& element : header.elements) {
    if (element.properties.empty()) continue;
    for (uint64_t i = 0; i < element.count;) {
      if (!lines.Next(line)) return PlyTooShort(element, i);
      i += line.find_first_not_of(" \t") != std::string_view::npos;
    }
  }
  while (lines.Next(line)) {
    if (line.find_first_not_of(" \t") == std::string_view::npos) continue;
    return Invalid(
        "lines follow the last element that its header promises: its counts are wrong, " +
        std::string(kAgain));
  }
  return Status::Ok();
}

Status CheckPly(ByteView file) {
  Lines lines(AsText(file));
  Result<PlyHeader> header = ReadPlyHeader(lines);
  if (!header.ok()) return header.status();
  for (const PlyElement& element : header->elements) {
    if (element.name == "face" && element.count > mesh::kMaxTriangles)
      return TooMany(element.count);
  }
  return header->format == PlyFormat::kText ? CheckPlyText(*header, lines)
                                            : CheckPlyBinary(*header, AsBytes(lines.rest()));
}

Status CheckObj(ByteView file) {
  Lines lines(AsText(file));
  // 3: a file that ends without any face is not half of one.
  uint64_t triangles = 0, last = 3;
  bool face = false;
  for (std::string_view line; lines.Next(line);) {
    face = Word(line) == "f";
    if (!face) continue;
    for (last = 0; !Word(line).empty();) ++last;
    triangles += last > 2 ? last - 2 : 0;
  }
  if (triangles > mesh::kMaxTriangles) return TooMany(triangles);
  if (face && !lines.whole() && last < 3)
    return Invalid("its last line is half a face: the file is cut short, " + std::string(kAgain));
  return Status::Ok();
}

// Numbers and words of a text, comments from '#' to the line's end left out.
class Words {
 public:
  explicit Words(std::string_view text) : lines_(text) {}
  std::string_view Next() {
    for (;;) {
      if (const std::string_view word = Word(line_); !word.empty()) return word;
      if (!lines_.Next(line_)) return {};
      line_ = line_.substr(0, line_.find('#'));
    }
  }
  void SkipLine() { line_ = {}; }

 private:
  Lines lines_;
  std::string_view line_;
};

Status OffTooShort(const char* what, uint64_t promised, uint64_t found) {
  return Invalid("it promises " + std::to_string(promised) + " " + what + ", the file holds " +
                 std::to_string(found) + ": it is cut short or its counts are wrong, " +
                 std::string(kAgain));
}

Status CheckOff(ByteView file) {
  Words words(AsText(file));
  std::string_view word = words.Next();
  // "OFF", with letters before it for more than coordinates; the first count may follow at once.
  if (const size_t off = word.find("OFF"); off != std::string_view::npos) {
    word.remove_prefix(off + 3);
    if (word.empty()) word = words.Next();
  }
  uint64_t vertices = 0, faces = 0, edges = 0;
  if (!Number(word, vertices) || !Number(words.Next(), faces) || !Number(words.Next(), edges))
    return Invalid("expected 'OFF' and three counts at its beginning");
  if (faces > mesh::kMaxTriangles) return TooMany(faces);
  // Each takes a byte at least. From here on every loop ends with the file, and 3 * vertices fits.
  if (vertices > file.size()) return OffTooShort("vertices", vertices, 0);
  for (uint64_t i = 0; i < 3 * vertices; ++i) {
    const std::string_view word_at = words.Next();
    if (word_at.empty()) return OffTooShort("vertices", vertices, i / 3);
    if (!IsCoordinate(word_at))
      return Invalid("vertex " + std::to_string(i / 3) + " has a coordinate that is no number");
    if (i % 3 == 2) words.SkipLine();  // normals or colours
  }
  for (uint64_t i = 0; i < faces; ++i) {
    uint64_t corners = 0;
    bool whole = Number(words.Next(), corners) && corners <= file.size();
    if (whole && corners == 0) return Invalid("face " + std::to_string(i) + " has no corners");
    for (uint64_t k = 0; whole && k < corners; ++k) {
      uint64_t index = 0;
      whole = Number(words.Next(), index);
      if (whole && index >= vertices)
        return Invalid("a face names vertex " + std::to_string(index) + " of " +
                       std::to_string(vertices));
    }
    if (!whole) return OffTooShort("faces", faces, i);
    words.SkipLine();
  }
  return Status::Ok();
}

}  // namespace

Status CheckMeshBytes(ByteView file, std::string_view kind) {
  if (file.empty()) return Invalid("the file is empty");
  if (kind == "stl") return CheckStl(file);
  if (kind == "ply") return CheckPly(file);
  if (kind == "obj") return CheckObj(file);
  if (kind == "off") return CheckOff(file);
  return Status::Ok();
}

}  // namespace enamel::import
