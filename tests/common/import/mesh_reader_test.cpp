#include "common/import/mesh_reader.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <filesystem>
#include <limits>

#include "common/base/file.h"
#include "common/import/mesh_kind.h"
#include "common/mesh/mesh_repair.h"
#include "shapes.h"

namespace enamel::import {
namespace {

namespace fs = std::filesystem;

const mesh::Triangles kBox = BoxMesh(dvec3(-1, -2, -3), dvec3(4, 3, 2));

void Float(ByteWriter& out, double value) {
  out.U32(std::bit_cast<uint32_t>(static_cast<float>(value)));
}

Bytes BinaryStl(const mesh::Triangles& mesh, uint32_t count) {
  ByteWriter out;
  out.Raw(Bytes(80, 0));
  out.U32(count);
  for (const auto& t : mesh.indices) {
    for (int i = 0; i < 3; ++i) out.U32(0);
    for (uint32_t v : t)
      for (int k = 0; k < 3; ++k) Float(out, mesh.vertices[v][k]);
    out.U8(0);
    out.U8(0);
  }
  return out.Take();
}

std::string TextStl(const mesh::Triangles& mesh, const std::string& normal = "0 0 1") {
  std::string text = "solid box\n";
  for (const auto& t : mesh.indices) {
    text += "facet normal " + normal + "\nouter loop\n";
    for (uint32_t v : t) {
      const dvec3& p = mesh.vertices[v];
      text += "vertex " + std::to_string(p.x) + " " + std::to_string(p.y) + " " +
              std::to_string(p.z) + "\n";
    }
    text += "endloop\nendfacet\n";
  }
  return text + "endsolid box\n";
}

std::string TextObj(const mesh::Triangles& mesh, bool faces_first = false) {
  std::string vertices, faces;
  for (const dvec3& p : mesh.vertices)
    vertices +=
        "v " + std::to_string(p.x) + " " + std::to_string(p.y) + " " + std::to_string(p.z) + "\n";
  for (const auto& t : mesh.indices)
    faces += "f " + std::to_string(t[0] + 1) + "/1/1 " + std::to_string(t[1] + 1) + "//2 " +
             std::to_string(t[2] + 1) + "\n";
  return faces_first ? faces + vertices : vertices + faces;
}

std::string PlyHeader(const std::string& format, const std::string& vertices,
                      const std::string& faces) {
  return "ply\nformat " + format + " 1.0\nelement vertex " + vertices +
         "\nproperty float x\nproperty float y\nproperty float z\nelement face " + faces +
         "\nproperty list uchar int vertex_indices\nend_header\n";
}

std::string Upper(std::string text) {
  for (char& c : text) c = c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c;
  return text;
}

std::string Replaced(std::string text, const std::string& what, const std::string& with) {
  for (size_t at = 0; (at = text.find(what, at)) != text.npos; at += with.size())
    text.replace(at, what.size(), with);
  return text;
}

Bytes Utf16(const std::string& text, bool big, bool mark) {
  Bytes out;
  auto unit = [&](uint8_t low, uint8_t high) {
    out.push_back(big ? high : low);
    out.push_back(big ? low : high);
  };
  if (mark) unit(0xff, 0xfe);
  for (char c : text) unit(static_cast<uint8_t>(c), 0);
  return out;
}

Bytes AsFile(const std::string& text) { return Bytes(text.begin(), text.end()); }

// The refusal's message, empty when the file is read.
std::string Refusal(ByteView file, const std::string& kind) {
  auto mesh = ReadMesh(file, kind);
  return mesh.ok() ? "" : mesh.status().message();
}
std::string Refusal(const std::string& file, const std::string& kind) {
  return Refusal(AsBytes(file), kind);
}

void ExpectSays(const std::string& message, const std::string& part) {
  EXPECT_NE(message.find(part), std::string::npos) << message;
}

// A box of 125 mm3, closed, with as many notes as expected.
void ExpectBox(const Bytes& file, const std::string& kind, const std::string& note = {}) {
  auto mesh = ReadMesh(file, kind);
  ASSERT_TRUE(mesh.ok()) << mesh.status().message();
  EXPECT_EQ(mesh->mesh.indices.size(), 12u);
  EXPECT_NEAR(mesh::SignedVolume(mesh->mesh), 125, 1e-3);
  std::string notes;
  for (const std::string& line : mesh->notes) notes += line + "\n";
  EXPECT_EQ(notes.empty(), note.empty()) << notes;
  ExpectSays(notes, note);
}

TEST(StlTest, TextOfAnyExporterIsRead) {
  const std::string text = TextStl(kBox);
  for (const std::string& form :
       {text, Upper(text), Replaced(text, "vertex", "Vertex"), "\r\n \n\n  " + text,
        Replaced(text, "\n", "\r\n"), Replaced(text, "\n", "\r"),
        Replaced(text, "vertex ", "\tvertex\t"), TextStl(kBox, "-1.#IND -1.#IND -1.#IND"),
        TextStl(kBox, "nan(ind) -nan(ind) nan"), TextStl(kBox, "0,0 0,0 1,0"),
        Replaced(text, ".", ","), Replaced(text, ".000000", ".0E+000"),
        Replaced(text, ".000000", ".D+00"), Replaced(text, "endsolid box\n", "end solid"),
        Replaced(text, "solid box", "solid"), "\xef\xbb\xbf" + text, text + std::string(300, '\0'),
        text + "\x1a"}) {
    ExpectBox(AsFile(form), "stl");
  }
  for (bool big : {false, true}) ExpectBox(Utf16(text, big, true), "stl");
}

TEST(StlTest, SolidsBecomePartsOfTheirNames) {
  const std::string text = TextStl(kBox) + TextStl(BoxMesh(dvec3(0), dvec3(1)));
  auto mesh = ReadMesh(AsFile(text), "stl");
  ASSERT_TRUE(mesh.ok()) << mesh.status().message();
  ASSERT_EQ(mesh->parts.size(), 2u);
  EXPECT_EQ(mesh->parts[1].name, "box");
  EXPECT_EQ(mesh->parts[1].first, 12u);
}

TEST(StlTest, BinaryWithBytesAfterItsTrianglesIsReadWithANote) {
  const Bytes plain = BinaryStl(kBox, 12);
  ExpectBox(plain, "stl");
  for (const size_t more : {2u, 50u, 428u}) {
    Bytes zeros = plain, letters = plain;
    zeros.resize(plain.size() + more, 0);
    letters.resize(plain.size() + more, 'x');
    const std::string note = std::to_string(more) + " bytes after the last triangle";
    ExpectBox(zeros, "stl", note);
    ExpectBox(letters, "stl", note);
  }
  Bytes marked = AsFile("\xef\xbb\xbf" + std::string(AsText(plain)));
  ExpectBox(marked, "stl");
  Bytes solid = plain;
  std::copy_n("solid of a program that writes binary", 37, solid.begin());
  ExpectBox(solid, "stl");
}

TEST(StlTest, BinaryWhoseCountLiesIsRefusedWithBothFigures) {
  for (uint32_t lie : {0u, 11u, 13u, 4'000'000'000u}) {
    const std::string said = Refusal(BinaryStl(kBox, lie), "stl");
    ExpectSays(said, "promises " + std::to_string(lie) + " triangles");
    ExpectSays(said, "684 bytes");
  }
}

TEST(ObjTest, AnyOrderAndEncodingIsRead) {
  const std::string text = TextObj(kBox);
  for (const std::string& form : {text, TextObj(kBox, true), "\xef\xbb\xbf" + text,
                                  Replaced(text, "\n", "\r\n"), Replaced(text, "//2 ", "//2 \\\n"),
                                  Replaced(text, ".", ","), "mtllib none.mtl\n" + text + "# end"}) {
    ExpectBox(AsFile(form), "obj");
  }
  for (bool big : {false, true}) {
    ExpectBox(Utf16(text, big, true), "obj");
    ExpectBox(Utf16(text, big, false), "obj");
  }
}

TEST(ObjTest, NegativeIndicesCountBackwards) {
  auto mesh = ReadMesh(AsFile("v 0 0 0\nv 1 0 0\nv 0 1 0\nf -3 -2 -1\nv 5 5 5\n"), "obj");
  ASSERT_TRUE(mesh.ok());
  EXPECT_EQ(mesh->mesh.indices[0], (std::array<uint32_t, 3>{0, 1, 2}));
  ExpectSays(Refusal("v 0 0 0\nf -2 1 1\n", "obj"), "line 2: a face names vertex '-2'");
  ExpectSays(Refusal("v 0 0 0\nf 1 2 3\n", "obj"), "names vertex 1 of 1");
}

// A dart: its reflex corner is the fan's worst start.
TEST(ObjTest, APolygonWithAReflexCornerIsCutIntoTrianglesWithinIt) {
  for (int first = 0; first < 4; ++first) {
    std::string text = "v 0 0 0\nv 4 -2 0\nv 1 0 0\nv 4 2 0\nf";
    for (int k = 0; k < 4; ++k) text += " " + std::to_string(1 + (first + k) % 4);
    auto mesh = ReadMesh(AsFile(text + "\n"), "obj");
    ASSERT_TRUE(mesh.ok());
    EXPECT_NEAR(mesh::SurfaceArea(mesh->mesh), 2, 1e-12) << first;
  }
}

TEST(PlyTest, ElementsInAnyOrderAndStripsAreRead) {
  const std::string triangle = "0 0 0\n1 0 0\n0 1 0\n";
  const std::string faces_first =
      "ply\nformat ascii 1.0\nelement face 1\nproperty list uchar int vertex_index\n"
      "element vertex 3\nproperty double x\nproperty double y\nproperty double z\n"
      "property uchar red\nend_header\n3 0 1 2\n0 0 0 0.5\n1 0 0 7\n0 1 0 7\n";
  auto mesh = ReadMesh(AsFile(faces_first), "ply");
  ASSERT_TRUE(mesh.ok()) << mesh.status().message();
  EXPECT_EQ(mesh->mesh.indices[0], (std::array<uint32_t, 3>{0, 1, 2}));
  const std::string strips =
      "ply\nformat ascii 1.0\nelement vertex 5\nproperty float x\nproperty float y\n"
      "property float z\nelement tristrips 1\nproperty list int int vertex_indices\nend_header\n" +
      triangle + "1 1 0\n5 5 5\n8 0 1 2 3 -1 4 3 2\n";
  mesh = ReadMesh(AsFile(strips), "ply");
  ASSERT_TRUE(mesh.ok()) << mesh.status().message();
  const std::vector<std::array<uint32_t, 3>> expected = {{0, 1, 2}, {1, 3, 2}, {4, 3, 2}};
  EXPECT_EQ(mesh->mesh.indices, expected);
}

TEST(PlyTest, BinaryIsCountedListByList) {
  const std::string text = PlyHeader("binary_little_endian", "1", "2");
  Bytes file(text.begin(), text.end());
  const size_t header = file.size();
  file.resize(header + 12 + 1 + 12 + 1 + 16, 0);
  file[header + 12] = 3;
  file[header + 12 + 13] = 4;
  EXPECT_EQ(Refusal(file, "ply"), "");
  for (size_t n = header; n < file.size(); ++n)
    EXPECT_NE(Refusal(ByteView(file).first(n), "ply"), "") << n;
  file[header + 12 + 13] = 255;
  ExpectSays(Refusal(file, "ply"), "promises 2 of 'face', the file holds 1");
}

TEST(PlyTest, BothByteOrdersGiveTheSame) {
  for (const char* format : {"binary_little_endian", "binary_big_endian"}) {
    const std::string text = PlyHeader(format, "3", "1");
    Bytes file(text.begin(), text.end());
    auto add = [&](uint32_t value) {
      for (int i = 0; i < 4; ++i)
        file.push_back(static_cast<uint8_t>(value >> (8 * (format[7] == 'l' ? i : 3 - i))));
    };
    for (float c : {0.f, 0.f, 0.f, 1.5f, 0.f, 0.f, 0.f, -2.f, 0.f}) add(std::bit_cast<uint32_t>(c));
    file.push_back(3);
    for (uint32_t i : {0u, 1u, 2u}) add(i);
    auto mesh = ReadMesh(file, "ply");
    ASSERT_TRUE(mesh.ok()) << format << mesh.status().message();
    EXPECT_EQ(mesh->mesh.vertices[1], dvec3(1.5, 0, 0));
    EXPECT_EQ(mesh->mesh.vertices[2], dvec3(0, -2, 0));
  }
}

TEST(OffTest, CommentsColoursAndAJoinedHeaderAreRead) {
  EXPECT_EQ(Refusal("#x\nOFF # y\n3 1 0\n\n0 0 0\n1 0 0 # z\n0 1 0\n3 0 1 2 255 0 0\n", "off"), "");
  EXPECT_EQ(Refusal("OFF3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2", "off"), "");
  ExpectSays(Refusal("OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n", "off"), "vertex 3 of 3");
  ExpectSays(Refusal("OFF\n3 1 0\n0 0 0\n1z 0 0\n0 1 0\n3 0 1 2\n", "off"), "vertex 1 has a");
  ExpectSays(Refusal("OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n0\n", "off"), "face 0 has no corners");
}

TEST(MeshReaderTest, CornersThatAreNoNumbersTakeTheirTrianglesAlongAndAreCounted) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  Bytes stl = BinaryStl(kBox, 12);
  for (size_t i = 0; i < 4; ++i)
    stl[84 + 12 + i] = static_cast<uint8_t>(std::bit_cast<uint32_t>(nan) >> (8 * i));
  const std::string obj =
      Replaced(TextObj(kBox), "v -1.000000 -2.000000 -3.000000", "v nan 0 -1.#IND");
  const std::pair<Bytes, std::string> files[] = {{stl, "stl"}, {AsFile(obj), "obj"}};
  for (const auto& [file, kind] : files) {
    auto mesh = ReadMesh(file, kind);
    ASSERT_TRUE(mesh.ok()) << mesh.status().message();
    ASSERT_EQ(mesh->notes.size(), 1u);
    const size_t lost = 12 - mesh->mesh.indices.size();
    EXPECT_GE(lost, 1u);
    ExpectSays(mesh->notes[0], std::to_string(lost) + " of 12 triangles left out");
  }
  ExpectSays(Refusal("v nan 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "obj"), "none of its 1 triangles");
}

TEST(MeshReaderTest, DoublesFarFromTheOriginKeepTheirDigits) {
  mesh::Triangles far = kBox;
  for (dvec3& v : far.vertices) v = 0.001 * v + dvec3(4e7, -5e7, 6e7);
  auto mesh = ReadMesh(AsFile(TextObj(far)), "obj");
  ASSERT_TRUE(mesh.ok());
  auto back = mesh::DecodeMesh(mesh::EncodeMesh(*mesh));
  ASSERT_TRUE(back.ok());
  EXPECT_NEAR(mesh::SignedVolume(back->mesh), 125e-9, 1e-11);
}

TEST(MeshReaderTest, FilesCutShortAreRefusedAndSayWhatIsMissing) {
  const Bytes stl = BinaryStl(kBox, 12);
  for (size_t n = 0; n < stl.size(); n += 7)
    EXPECT_NE(Refusal(ByteView(stl).first(n), "stl"), "") << n;
  ExpectSays(Refusal("solid x\nfacet normal 0 0 0\nouter loop\nvertex 1 2 3\n", "stl"), "endsolid");
  ExpectSays(Refusal("ply\nformat ascii 1.0\nelement vertex 3\n", "ply"), "end_header");
  ExpectSays(Refusal(PlyHeader("ascii", "3", "1") + "0 0 0\n1 0 0\n", "ply"),
             "promises 3 of 'vertex', the file holds 2");
  ExpectSays(Refusal(PlyHeader("ascii", "3", "1") + "0 0 0\n1 0\n0 1 0\n3 0 1 2\n", "ply"),
             "'vertex' 1 has too few numbers");
  ExpectSays(Refusal("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2", "obj"), "half a face");
  ExpectSays(Refusal("OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1", "off"), "promises 1 faces");
}

TEST(MeshReaderTest, GiantCountsAreRefusedWithoutTheirMemory) {
  ExpectSays(Refusal(PlyHeader("ascii", "3", "10000000"), "ply"), "10000000 triangles");
  ExpectSays(Refusal(PlyHeader("binary_big_endian", "18446744073709551615", "1"), "ply"),
             "the file holds 0");
  ExpectSays(Refusal(PlyHeader("ascii", "-5", "1"), "ply"), "does not say how many");
  ExpectSays(Refusal("OFF\n4294967295 1 0\n0 0 0\n", "off"), "cut short");
  ExpectSays(Refusal("OFF\n4 4294967295 0\n", "off"), "4294967295 triangles");
}

TEST(MeshReaderTest, MoreThanTwoMillionTrianglesAreRefused) {
  std::string text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\n";
  const size_t faces = mesh::kMaxTriangles / 2 + 1;  // of four corners: two triangles each
  text.reserve(text.size() + 10 * faces);
  for (size_t i = 0; i < faces; ++i) text += "f 1 2 3 4\n";
  ExpectSays(Refusal(text, "obj"), "more than 2000000 triangles");
}

TEST(MeshReaderTest, WhatIsNoMeshIsNamedWithWhatToDo) {
  const std::string text = "once upon a time there was no tooth\n";
  ExpectSays(Refusal(text + text + text, "stl"), "begins with 'solid'");
  ExpectSays(Refusal(text, "ply"), "first line 'ply'");
  ExpectSays(Refusal(text, "off"), "three counts");
  for (const char* kind : {"stl", "ply", "obj", "off"}) ExpectSays(Refusal("", kind), "empty");
  for (const std::string& begin : {std::string("PK\x03\x04"), std::string("glTF\x02"),
                                   std::string("ISO-10303-21;"), std::string(128, '\0') + "DICM",
                                   std::string("<?xml version=\"1.0\"?>\n<HPS version=\"1\">"),
                                   std::string("Kaydara FBX Binary")}) {
    ExpectSays(Refusal(begin + std::string(200, 'x'), "stl"), "STL");
  }
  for (const char* kind : {"3mf", "glb", "dcm", "step", "doc"})
    ExpectSays(CheckMeshKind(kind).message(), "STL");
}

TEST(MeshReaderTest, AFileUnderTheNameOfAnotherFormatIsReadAsWhatItHolds) {
  ExpectBox(AsFile(TextStl(kBox)), "ply", "read as .stl");
}

// The files that the product refused, made by other programs' habits; all are the same kind of
// closed crown.
TEST(BorderMeshTest, EveryOneIsRead) {
  const fs::path folder = fs::path(ENAMEL_SHARED_DATA) / "borders/meshes";
  if (!fs::exists(folder)) GTEST_SKIP() << "skipped: no shared data";
  for (const auto& entry : fs::directory_iterator(folder)) {
    const std::string kind = entry.path().extension().string().substr(1);
    if (kind == "py") continue;
    auto bytes = ReadFile(entry.path(), mesh::kMaxMeshFile);
    ASSERT_TRUE(bytes.ok());
    auto mesh = ReadMesh(*bytes, kind);
    ASSERT_TRUE(mesh.ok()) << entry.path() << mesh.status().message();
    auto solid = mesh::MakeSolid(mesh->mesh);
    ASSERT_TRUE(solid.ok()) << entry.path() << solid.status().message();
    EXPECT_GT(mesh::SignedVolume(solid->mesh), 100) << entry.path();
  }
}

}  // namespace
}  // namespace enamel::import
