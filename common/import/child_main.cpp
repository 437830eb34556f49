// enamel-import-child FILE: reads one mesh file and writes its triangles to standard output
// (triangles.h). A mesh library is a large attack surface: it runs here, with limits, without
// files, network or children, and never inside the station or the server. Exit: 0 and a triangle
// list; 1 and one line on standard error, also where the kernel cannot confine it.
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <unistd.h>

#include <algorithm>
#include <assimp/Importer.hpp>
#include <cctype>
#include <cmath>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <string>

#include "common/base/file.h"
#include "common/import/child_sandbox.h"
#include "common/import/triangles.h"

namespace enamel::import {
namespace {

Status Invalid(const std::string& what) { return Status(Code::kInvalidInput, what); }

std::string Extension(const std::filesystem::path& path) {
  std::string ext = path.extension().string();
  if (!ext.empty()) ext.erase(0, 1);
  std::transform(ext.begin(), ext.end(), ext.begin(),
                 [](unsigned char c) { return std::tolower(c); });
  return ext;
}

Status AddMesh(const aiMesh& mesh, Triangles& out) {
  if (out.vertices.size() + mesh.mNumVertices > kMaxVertices ||
      out.indices.size() + mesh.mNumFaces > kMaxTriangles) {
    return Invalid("more than " + std::to_string(kMaxTriangles) +
                   " triangles: reduce the mesh first");
  }
  auto first = static_cast<uint32_t>(out.vertices.size());
  for (unsigned i = 0; i < mesh.mNumVertices; ++i) {
    const aiVector3D& v = mesh.mVertices[i];
    if (!std::isfinite(v.x) || !std::isfinite(v.y) || !std::isfinite(v.z)) {
      return Invalid("vertex " + std::to_string(i) +
                     " has a coordinate that is not a finite number");
    }
    out.vertices.emplace_back(v.x, v.y, v.z);
  }
  for (unsigned i = 0; i < mesh.mNumFaces; ++i) {
    const aiFace& f = mesh.mFaces[i];
    if (f.mNumIndices != 3) continue;  // points and lines
    for (unsigned k = 0; k < 3; ++k) {
      if (f.mIndices[k] >= mesh.mNumVertices)
        return Invalid("a face names a vertex that is not there");
    }
    out.indices.push_back({first + f.mIndices[0], first + f.mIndices[1], first + f.mIndices[2]});
  }
  return Status::Ok();
}

Result<Triangles> ReadMesh(const Bytes& file, const std::string& extension) {
  Assimp::Importer importer;
  const aiScene* scene = importer.ReadFileFromMemory(file.data(), file.size(),
                                                     aiProcess_Triangulate, extension.c_str());
  if (scene == nullptr) return Invalid(std::string("cannot be read: ") + importer.GetErrorString());
  Triangles out;
  for (unsigned i = 0; i < scene->mNumMeshes; ++i)
    ENAMEL_RETURN_IF_ERROR(AddMesh(*scene->mMeshes[i], out));
  if (out.indices.empty()) return Invalid("holds no triangles, only points or nothing");
  return out;
}

bool WriteAll(const Bytes& bytes) {
  size_t done = 0;
  while (done < bytes.size()) {
    ssize_t n = write(STDOUT_FILENO, bytes.data() + done, bytes.size() - done);
    if (n <= 0) return false;
    done += static_cast<size_t>(n);
  }
  return true;
}

int Fail(const std::string& message) {
  std::fprintf(stderr, "%s\n", message.c_str());
  return 1;
}

int Run(const std::filesystem::path& path) {
  LimitResources();
  Result<Bytes> file = ReadFile(path, kMaxMeshFile);
  if (!file.ok()) return Fail(file.status().message());
  if (file->empty()) return Fail("the file is empty");
  if (!ForbidSystem()) {
    return Fail(
        "expected a kernel that can confine the mesh reader (seccomp filters), found none: mesh "
        "files are not read unconfined; import on another machine and copy the scene's folder");
  }
  Result<Triangles> mesh = ReadMesh(*file, Extension(path));
  if (!mesh.ok()) return Fail(mesh.status().message());
  return WriteAll(EncodeTriangles(*mesh)) ? 0 : 1;
}

}  // namespace
}  // namespace enamel::import

int main(int argc, char** argv) {
  if (argc != 2) return enamel::import::Fail("usage: enamel-import-child FILE");
  try {
    return enamel::import::Run(argv[1]);
  } catch (const std::exception& e) {
    return enamel::import::Fail(std::string("cannot be read: ") + e.what());
  }
}
