#include "common/import/mesh_reader.h"

#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include <algorithm>
#include <assimp/Importer.hpp>
#include <cmath>
#include <string_view>

#include "common/import/mesh_file_check.h"
#include "common/import/printable.h"

namespace enamel::import {
namespace {

Status Invalid(const std::string& what) { return Status(Code::kInvalidInput, what); }

// Before the library makes triangles of polygons: it reads their corners without looking, and gives
// up the process over coordinates whose products overflow.
Status CheckMeshes(const aiScene& scene) {
  constexpr float kFarthest = 1e9f;  // a kilometre in micrometres
  for (unsigned m = 0; m < scene.mNumMeshes; ++m) {
    const aiMesh& mesh = *scene.mMeshes[m];
    for (unsigned i = 0; i < mesh.mNumVertices; ++i) {
      const aiVector3D& v = mesh.mVertices[i];
      if (!std::isfinite(v.x) || !std::isfinite(v.y) || !std::isfinite(v.z)) {
        return Invalid("vertex " + std::to_string(i) +
                       " has a coordinate that is not a finite number");
      }
      if (std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)}) > kFarthest) {
        return Invalid("vertex " + std::to_string(i) +
                       " has a coordinate beyond 1000000000: the file is damaged, export it again");
      }
    }
    for (unsigned i = 0; i < mesh.mNumFaces; ++i) {
      const aiFace& f = mesh.mFaces[i];
      for (unsigned k = 0; k < f.mNumIndices; ++k) {
        if (f.mIndices[k] >= mesh.mNumVertices)
          return Invalid("a face names a vertex that does not exist: export the file again");
      }
    }
  }
  return Status::Ok();
}

Status AddMesh(const aiMesh& mesh, mesh::Triangles& out) {
  if (out.vertices.size() + mesh.mNumVertices > mesh::kMaxVertices ||
      out.indices.size() + mesh.mNumFaces > mesh::kMaxTriangles) {
    return Status(Code::kTooLarge, "more than " + std::to_string(mesh::kMaxTriangles) +
                                       " triangles: reduce the mesh in a mesh program first");
  }
  auto first = static_cast<uint32_t>(out.vertices.size());
  for (unsigned i = 0; i < mesh.mNumVertices; ++i) {
    const aiVector3D& v = mesh.mVertices[i];
    out.vertices.emplace_back(v.x, v.y, v.z);
  }
  for (unsigned i = 0; i < mesh.mNumFaces; ++i) {
    const aiFace& f = mesh.mFaces[i];
    if (f.mNumIndices != 3) continue;  // points and lines
    out.indices.push_back({first + f.mIndices[0], first + f.mIndices[1], first + f.mIndices[2]});
  }
  return Status::Ok();
}

std::string Name(const aiString& text) {
  return Printable(std::string(text.C_Str(), std::min<size_t>(text.length, mesh::kMaxPartName)));
}

std::string MaterialName(const aiScene& scene, const aiMesh& mesh) {
  if (mesh.mMaterialIndex >= scene.mNumMaterials) return {};
  aiString text;
  if (scene.mMaterials[mesh.mMaterialIndex]->Get(AI_MATKEY_NAME, text) != aiReturn_SUCCESS)
    return {};
  const std::string name = Name(text);
  return name == AI_DEFAULT_MATERIAL_NAME ? std::string() : name;
}

// An OBJ file without its mention of a material library: the library would look for one, and
// without one parse the OBJ file itself as materials. Names of materials in the faces stay. Names
// of objects become one word: the library keeps only the first.
Bytes PreparedObj(ByteView file) {
  constexpr std::string_view kWord = "mtllib";
  Bytes out(file.begin(), file.end());
  for (auto at = out.begin();
       (at = std::search(at, out.end(), kWord.begin(), kWord.end())) != out.end();)
    *at = '#';
  for (size_t i = 0; i + 2 < out.size(); ++i) {
    const bool starts = i == 0 || out[i - 1] == '\n' || out[i - 1] == '\r';
    if (!starts || out[i] != 'o' || out[i + 1] != ' ') continue;
    for (i += 2; i < out.size() && out[i] != '\n' && out[i] != '\r'; ++i) {
      const bool follows = i + 1 < out.size() && out[i + 1] > ' ';
      if (out[i] == ' ' && out[i - 1] > ' ' && follows) out[i] = '_';
    }
  }
  return out;
}

}  // namespace

Result<mesh::NamedMesh> ReadMesh(ByteView file, const std::string& kind) {
  ENAMEL_RETURN_IF_ERROR(CheckMeshBytes(file, kind));
  Assimp::Importer importer;
  const Bytes obj = kind == "obj" ? PreparedObj(file) : Bytes();
  if (kind == "obj") file = obj;
  // No flag yet: what would make triangles trusts indices that CheckMeshes has not seen.
  const aiScene* scene = importer.ReadFileFromMemory(file.data(), file.size(), 0, kind.c_str());
  if (scene == nullptr) return Invalid(std::string("cannot be read: ") + importer.GetErrorString());
  ENAMEL_RETURN_IF_ERROR(CheckMeshes(*scene));
  scene = importer.ApplyPostProcessing(aiProcess_Triangulate);
  if (scene == nullptr) return Invalid(std::string("cannot be read: ") + importer.GetErrorString());
  mesh::NamedMesh out;
  for (unsigned i = 0; i < scene->mNumMeshes; ++i) {
    const aiMesh& mesh = *scene->mMeshes[i];
    const auto first = static_cast<uint32_t>(out.mesh.indices.size());
    ENAMEL_RETURN_IF_ERROR(AddMesh(mesh, out.mesh));
    const auto count = static_cast<uint32_t>(out.mesh.indices.size()) - first;
    if (count > 0 && out.parts.size() < mesh::kMaxParts)
      out.parts.push_back({Name(mesh.mName), MaterialName(*scene, mesh), first, count});
  }
  if (out.mesh.indices.empty()) return Invalid("holds no triangles, only points or nothing");
  return out;
}

}  // namespace enamel::import
