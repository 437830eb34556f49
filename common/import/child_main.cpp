// enamel-import-child FILE: reads one mesh file and writes its triangles to standard output
// (triangles.h, EncodeMesh). A mesh library is a large attack surface: it runs here, with limits,
// without files, network or children, and never inside the station or the server. Exit: 0 and a
// triangle list; 1 and one line on standard error, also where the kernel cannot confine it.
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <string>
#include <system_error>

#include "common/base/file.h"
#include "common/import/child_sandbox.h"
#include "common/import/mesh_reader.h"

namespace enamel::import {
namespace {

std::string Extension(const std::filesystem::path& path) {
  std::string ext = path.extension().string();
  if (!ext.empty()) ext.erase(0, 1);
  std::transform(ext.begin(), ext.end(), ext.begin(),
                 [](unsigned char c) { return std::tolower(c); });
  return ext;
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
  std::error_code error;
  if (const auto size = std::filesystem::file_size(path, error);
      !error && size > mesh::kMaxMeshFile) {
    return Fail("expected a file of at most " + std::to_string(mesh::kMaxMeshFile >> 20) +
                " MiB, found one of " + std::to_string(size >> 20) +
                " MiB: reduce the mesh in a mesh program (a crown needs no more than 200000 "
                "triangles)");
  }
  // Read while files can still be opened. From ForbidSystem on there are memory and standard
  // output.
  Result<Bytes> file = ReadFile(path, mesh::kMaxMeshFile);
  if (!file.ok()) return Fail(file.status().message());
  if (!ForbidSystem()) {
    return Fail(
        "expected a kernel that can confine the mesh reader (seccomp filters), found none: mesh "
        "files are not read unconfined; import on another machine and copy the scene's folder");
  }
  Result<mesh::NamedMesh> mesh = ReadMesh(*file, Extension(path));
  if (!mesh.ok()) return Fail(mesh.status().message());
  return WriteAll(mesh::EncodeMesh(*mesh)) ? 0 : 1;
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
