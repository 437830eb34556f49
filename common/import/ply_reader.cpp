#include <array>
#include <bit>
#include <cmath>
#include <string>
#include <vector>

#include "common/import/mesh_formats.h"
#include "common/import/mesh_text.h"

namespace enamel::import {
namespace {

constexpr std::string_view kAgain = "export it again";

Status Invalid(const std::string& what) { return Status(Code::kInvalidInput, what); }

struct Type {
  std::string_view name, other;
  size_t size;
  enum { kSigned, kUnsigned, kFloat } kind;
};
constexpr std::array<Type, 8> kTypes = {{{"char", "int8", 1, Type::kSigned},
                                         {"uchar", "uint8", 1, Type::kUnsigned},
                                         {"short", "int16", 2, Type::kSigned},
                                         {"ushort", "uint16", 2, Type::kUnsigned},
                                         {"int", "int32", 4, Type::kSigned},
                                         {"uint", "uint32", 4, Type::kUnsigned},
                                         {"float", "float32", 4, Type::kFloat},
                                         {"double", "float64", 8, Type::kFloat}}};

const Type* TypeNamed(std::string_view name) {
  for (const Type& t : kTypes) {
    if (IsWord(name, t.name) || IsWord(name, t.other)) return &t;
  }
  return nullptr;
}

struct Property {
  std::string_view name;
  const Type* count = nullptr;  // of a list's items; null: no list
  const Type* type = nullptr;
};

enum class Role { kOther, kVertex, kFace, kStrips };

struct Element {
  std::string_view name;
  uint64_t count = 0;
  std::vector<Property> properties;
  Role role = Role::kOther;
  std::array<size_t, 3> place{};  // of a vertex: its properties x, y, z
  size_t corners = 0;             // of a face: its list of vertices
};

enum class Format { kText, kLittle, kBig };

struct Header {
  Format format = Format::kText;
  std::vector<Element> elements;
};

Status ReadProperty(std::string_view line, Element& element) {
  Property property;
  std::string_view type = Word(line);
  if (IsWord(type, "list")) {
    property.count = TypeNamed(Word(line));
    type = property.count != nullptr && property.count->kind != Type::kFloat ? Word(line)
                                                                             : std::string_view();
  }
  property.type = TypeNamed(type);
  property.name = Word(line);
  if (property.type == nullptr) return Invalid("its header has a property of no known type");
  element.properties.push_back(property);
  return Status::Ok();
}

// What is to be taken of an element.
Status FindRole(Element& element) {
  if (element.count == 0) return Status::Ok();
  if (IsWord(element.name, "vertex")) {
    constexpr std::array<std::string_view, 3> kAxes = {"x", "y", "z"};
    for (size_t axis = 0; axis < 3; ++axis) {
      bool found = false;
      for (size_t i = 0; i < element.properties.size(); ++i) {
        const Property& p = element.properties[i];
        if (p.count != nullptr || !IsWord(p.name, kAxes[axis])) continue;
        element.place[axis] = i;
        found = true;
      }
      if (!found)
        return Invalid("its vertices have no property '" + std::string(kAxes[axis]) +
                       "': " + std::string(kAgain));
    }
    element.role = Role::kVertex;
    return Status::Ok();
  }
  const bool strips = IsWord(element.name, "tristrips");
  if (!strips && !IsWord(element.name, "face")) return Status::Ok();
  for (size_t i = 0; i < element.properties.size(); ++i) {
    const Property& p = element.properties[i];
    const bool named = IsWord(p.name, "vertex_indices") || IsWord(p.name, "vertex_index");
    if (p.count == nullptr || p.type->kind == Type::kFloat || !named) continue;
    element.role = strips ? Role::kStrips : Role::kFace;
    element.corners = i;
  }
  if (element.role == Role::kOther)
    return Invalid("its faces have no list 'vertex_indices': " + std::string(kAgain));
  return Status::Ok();
}

Result<Header> ReadHeader(Lines& lines) {
  // A header is some ten lines; without a bound a file of short lines would be a header of all of
  // it.
  constexpr int kMaxLines = 10'000;
  Header header;
  std::string_view line;
  if (!lines.Next(line) || Word(line) != "ply") return Invalid("expected a first line 'ply'");
  for (int i = 0; i < kMaxLines && lines.Next(line); ++i) {
    const std::string_view word = Word(line);
    if (word == "end_header") {
      for (Element& element : header.elements) ENAMEL_RETURN_IF_ERROR(FindRole(element));
      return header;
    }
    if (word == "format") {
      const std::string_view format = Word(line);
      header.format = format == "binary_big_endian"      ? Format::kBig
                      : format == "binary_little_endian" ? Format::kLittle
                                                         : Format::kText;
    } else if (word == "element") {
      Element element;
      element.name = Word(line);
      if (!Number(Word(line), element.count))
        return Invalid("its header does not say how many '" +
                       std::string(element.name.substr(0, 40)) + "' there are");
      header.elements.push_back(element);
    } else if (word == "property" && !header.elements.empty()) {
      ENAMEL_RETURN_IF_ERROR(ReadProperty(line, header.elements.back()));
    }
  }
  return Invalid("its header has no end ('end_header'): the file is cut short, " +
                 std::string(kAgain));
}

Status TooShort(const Element& element, uint64_t found) {
  return Invalid("its header promises " + std::to_string(element.count) + " of '" +
                 std::string(element.name.substr(0, 40)) + "', the file holds " +
                 std::to_string(found) + ": it is cut short or its counts are wrong, " +
                 std::string(kAgain));
}

// Values one after the other, from text or from bytes.
class TextValues {
 public:
  explicit TextValues(Lines lines) : lines_(lines) {}
  bool NextElement() {
    for (;;) {
      if (!lines_.Next(line_)) return false;
      if (line_.find_first_not_of(" \t") != std::string_view::npos) return true;
    }
  }
  bool Value(const Type& type, double& value) {
    const std::string_view word = Word(line_);
    if (type.kind == Type::kFloat) return !word.empty() && Coordinate(word, value);
    int64_t whole = 0;
    if (SignedNumber(word, whole)) {
      value = static_cast<double>(whole);
      return true;
    }
    // Some programs write 0.5 for what the header calls an integer, a colour mostly.
    return Coordinate(word, value) && std::abs(value) < 1e15;
  }
  Status Broken(const Element& element, uint64_t i) const {
    return Invalid("'" + std::string(element.name.substr(0, 40)) + "' " + std::to_string(i) +
                   " has too few numbers on its line, or a word that is none: the file is "
                   "damaged, " +
                   std::string(kAgain));
  }
  Status CheckEnd() {
    while (lines_.Next(line_)) {
      if (line_.find_first_not_of(" \t") == std::string_view::npos) continue;
      return Invalid(
          "lines follow the last element that its header promises: its counts are wrong, " +
          std::string(kAgain));
    }
    return Status::Ok();
  }

 private:
  Lines lines_;
  std::string_view line_;
};

class BinaryValues {
 public:
  BinaryValues(ByteView data, bool big) : data_(data), big_(big) {}
  bool NextElement() { return true; }
  bool Value(const Type& type, double& value) {
    if (data_.size() < type.size) return false;
    uint64_t bits = 0;
    for (size_t i = 0; i < type.size; ++i)
      bits |= uint64_t{data_[i]} << (8 * (big_ ? type.size - 1 - i : i));
    data_ = data_.subspan(type.size);
    if (type.kind == Type::kFloat) {
      value = type.size == 8
                  ? std::bit_cast<double>(bits)
                  : static_cast<double>(std::bit_cast<float>(static_cast<uint32_t>(bits)));
    } else if (type.kind == Type::kSigned) {
      const uint64_t sign = uint64_t{1} << (8 * type.size - 1);
      value = static_cast<double>(static_cast<int64_t>((bits ^ sign) - sign));
    } else {
      value = static_cast<double>(bits);
    }
    return true;
  }
  Status Broken(const Element& element, uint64_t i) const { return TooShort(element, i); }
  Status CheckEnd() const {
    constexpr size_t kSlack = 16;  // some writers end with a line end
    if (data_.size() <= kSlack) return Status::Ok();
    return Invalid(std::to_string(data_.size()) +
                   " bytes follow the last element that its header promises: its counts are "
                   "wrong, " +
                   std::string(kAgain));
  }

 private:
  ByteView data_;
  bool big_;
};

// Every strip's triangles; each second one runs the other way around. -1 begins another strip.
Status AddStrips(const std::vector<double>& strip, MeshBuilder& out) {
  size_t first = 0;
  for (size_t i = 0; i < strip.size(); ++i) {
    if (strip[i] < 0) {
      first = i + 1;
      continue;
    }
    if (i < first + 2) continue;
    const bool odd = (i - first) % 2 != 0;
    for (size_t k : {i - 2, odd ? i : i - 1, odd ? i - 1 : i})
      out.AddCorner(static_cast<uint64_t>(strip[k]));
    ENAMEL_RETURN_IF_ERROR(out.EndFace());
  }
  return Status::Ok();
}

template <typename Values>
class BodyReader {
 public:
  BodyReader(Values values, MeshBuilder& out) : values_(values), out_(out) {}

  Status Read(const Header& header) {
    for (const Element& element : header.elements) {
      // Takes no bytes, so its count is bounded by nothing: it must not be counted through.
      if (element.properties.empty()) continue;
      for (uint64_t i = 0; i < element.count; ++i) {
        if (!values_.NextElement()) return TooShort(element, i);
        if (!ReadValues(element)) return values_.Broken(element, i);
        ENAMEL_RETURN_IF_ERROR(Take(element));
      }
    }
    return values_.CheckEnd();
  }

 private:
  // One element's: the single ones into single_, the list of corners into corners_.
  bool ReadValues(const Element& element) {
    single_.assign(element.properties.size(), 0);
    corners_.clear();
    for (size_t i = 0; i < element.properties.size(); ++i) {
      const Property& property = element.properties[i];
      if (property.count == nullptr) {
        if (!values_.Value(*property.type, single_[i])) return false;
        continue;
      }
      double count = 0, value = 0;
      if (!values_.Value(*property.count, count)) return false;
      const bool wanted =
          element.role != Role::kOther && element.role != Role::kVertex && i == element.corners;
      // Each item takes a byte at least, so this ends with the file.
      for (double k = 0; k < count; ++k) {
        if (!values_.Value(*property.type, value)) return false;
        if (wanted) corners_.push_back(value);
      }
    }
    return true;
  }

  Status Take(const Element& element) {
    if (element.role == Role::kVertex) {
      const auto& at = element.place;
      return out_.AddVertex({single_[at[0]], single_[at[1]], single_[at[2]]});
    }
    if (element.role == Role::kStrips) return AddStrips(corners_, out_);
    if (element.role == Role::kOther) return Status::Ok();
    for (double corner : corners_) {
      if (corner < 0)
        return Invalid("a face names a vertex below 0: the file is damaged, " +
                       std::string(kAgain));
      out_.AddCorner(static_cast<uint64_t>(corner));
    }
    return out_.EndFace();
  }

  Values values_;
  MeshBuilder& out_;
  std::vector<double> single_, corners_;
};

}  // namespace

Status ReadPly(ByteView file, MeshBuilder& out) {
  if (HasUtf8Mark(file)) file = file.subspan(kUtf8Mark);
  Bytes converted;
  std::string_view text = AsText(file);
  // Binary data may begin with what looks like another encoding, "ply" never does.
  if (!text.starts_with("ply")) text = PlainText(file, converted);
  Lines lines(text);
  ENAMEL_ASSIGN_OR_RETURN(const Header header, ReadHeader(lines));
  for (const Element& element : header.elements) {
    if (element.role == Role::kFace && element.count > mesh::kMaxTriangles) {
      return Status(Code::kTooLarge, std::to_string(element.count) +
                                         " triangles, expected at most " +
                                         std::to_string(mesh::kMaxTriangles) +
                                         ": reduce the mesh in a mesh program (a crown needs no "
                                         "more than 200000)");
    }
  }
  if (header.format == Format::kText)
    return BodyReader<TextValues>(TextValues(lines), out).Read(header);
  return BodyReader<BinaryValues>(
             BinaryValues(AsBytes(lines.rest()), header.format == Format::kBig), out)
      .Read(header);
}

}  // namespace enamel::import
