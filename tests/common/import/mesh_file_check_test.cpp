#include "common/import/mesh_file_check.h"

#include <gtest/gtest.h>

#include <bit>

#include "common/mesh/triangles.h"
#include "shapes.h"

namespace enamel::import {
namespace {

Bytes BinaryStl(const mesh::Triangles& mesh, uint32_t count) {
  ByteWriter out;
  out.Raw(Bytes(80, 0));
  out.U32(count);
  for (const auto& t : mesh.indices) {
    for (int i = 0; i < 3; ++i) out.U32(0);
    for (uint32_t v : t)
      for (int k = 0; k < 3; ++k)
        out.U32(std::bit_cast<uint32_t>(static_cast<float>(mesh.vertices[v][k])));
    out.U8(0);
    out.U8(0);
  }
  return out.Take();
}

std::string PlyHeader(const std::string& format, const std::string& vertices,
                      const std::string& faces) {
  return "ply\nformat " + format + " 1.0\nelement vertex " + vertices +
         "\nproperty float x\nproperty float y\nproperty float z\nelement face " + faces +
         "\nproperty list uchar int vertex_indices\nend_header\n";
}

// The refusal's message, empty when the file may be read.
std::string Refusal(ByteView file, std::string_view kind) {
  const Status status = CheckMeshBytes(file, kind);
  return status.ok() ? "" : status.message();
}
std::string Refusal(const std::string& file, std::string_view kind) {
  return Refusal(AsBytes(file), kind);
}

void ExpectSays(const std::string& message, const std::string& part) {
  EXPECT_NE(message.find(part), std::string::npos) << message;
}

TEST(MeshFileCheckTest, BinaryStlWhoseCountLiesIsRefusedWithBothFigures) {
  const mesh::Triangles box = BoxMesh(dvec3(0), dvec3(5));
  EXPECT_EQ(Refusal(BinaryStl(box, 12), "stl"), "");
  for (uint32_t lie : {0u, 11u, 13u, 4'000'000'000u}) {
    const std::string said = Refusal(BinaryStl(box, lie), "stl");
    ExpectSays(said, "promises " + std::to_string(lie) + " triangles");
    ExpectSays(said, "684 bytes");
  }
}

TEST(MeshFileCheckTest, FilesCutShortAreRefusedAndSayWhatIsMissing) {
  const Bytes stl = BinaryStl(BoxMesh(dvec3(0), dvec3(5)), 12);
  for (size_t n = 0; n < stl.size(); n += 7)
    EXPECT_NE(Refusal(ByteView(stl).first(n), "stl"), "") << n;
  ExpectSays(Refusal("solid x\nfacet normal 0 0 0\nouter loop\nvertex 1 2 3\n", "stl"), "endsolid");
  ExpectSays(Refusal("ply\nformat ascii 1.0\nelement vertex 3\n", "ply"), "end_header");
  ExpectSays(Refusal(PlyHeader("ascii", "3", "1") + "0 0 0\n1 0 0\n", "ply"),
             "promises 3 of 'vertex', the file holds 2");
  ExpectSays(Refusal("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2", "obj"), "half a face");
  ExpectSays(Refusal("OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1", "off"), "promises 1 faces");
}

TEST(MeshFileCheckTest, BinaryPlyIsCountedListByList) {
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

TEST(MeshFileCheckTest, GiantCountsAreRefusedWithoutTheirMemory) {
  ExpectSays(Refusal(PlyHeader("ascii", "3", "10000000"), "ply"), "10000000 triangles");
  ExpectSays(Refusal(PlyHeader("binary_big_endian", "18446744073709551615", "1"), "ply"),
             "the file holds 0");
  ExpectSays(Refusal(PlyHeader("ascii", "-5", "1"), "ply"), "does not say how many");
  ExpectSays(Refusal("OFF\n4294967295 1 0\n0 0 0\n", "off"), "cut short");
  ExpectSays(Refusal("OFF\n4 4294967295 0\n", "off"), "4294967295 triangles");
}

TEST(MeshFileCheckTest, ObjOfMoreThanTwoMillionTrianglesIsRefusedWithTheNumber) {
  std::string text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\n";
  const size_t faces = mesh::kMaxTriangles / 2 + 1;  // of four corners: two triangles each
  text.reserve(text.size() + 10 * faces);
  for (size_t i = 0; i < faces; ++i) text += "f 1 2 3 4\n";
  ExpectSays(Refusal(text, "obj"), std::to_string(2 * faces) + " triangles, expected at most");
}

TEST(MeshFileCheckTest, TextThatIsNoMeshIsRefused) {
  const std::string text = "once upon a time there was no tooth\n";
  ExpectSays(Refusal(text + text + text, "stl"), "begins with 'solid'");
  ExpectSays(Refusal(text, "ply"), "first line 'ply'");
  ExpectSays(Refusal(text, "off"), "three counts");
  for (const char* kind : {"stl", "ply", "obj", "off"}) ExpectSays(Refusal("", kind), "empty");
}

TEST(MeshFileCheckTest, OffWithCommentsColoursAndAJoinedHeaderMayBeRead) {
  EXPECT_EQ(Refusal("#x\nOFF # y\n3 1 0\n\n0 0 0\n1 0 0 # z\n0 1 0\n3 0 1 2 255 0 0\n", "off"), "");
  EXPECT_EQ(Refusal("OFF3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2", "off"), "");
  ExpectSays(Refusal("OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n", "off"), "vertex 3 of 3");
  ExpectSays(Refusal("OFF\n3 1 0\n0 0 0\n1z 0 0\n0 1 0\n3 0 1 2\n", "off"), "vertex 1 has a");
  ExpectSays(Refusal("OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n0\n", "off"), "face 0 has no corners");
}

}  // namespace
}  // namespace enamel::import
