// enamel-import-child KIND: reads one mesh file of that kind ("stl") from standard input and writes
// its triangles to standard output (triangles.h, EncodeMesh). Files come from
// strangers: they are parsed here, with limits, without files, network or children, and never inside
// the station or the server. Exit: 0 and a triangle list; 1 and one line on standard error, also where
// the kernel cannot confine it.
#include <unistd.h>

#include <cstdio>
#include <exception>
#include <string>

#include "common/base/file.h"
#include "common/import/child_sandbox.h"
#include "common/import/mesh_reader.h"

namespace enamel::import {
namespace {

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

int Run(const std::string& kind) {
  LimitResources();
  // Read while files can still be opened. From ForbidSystem on there are memory and standard
  // output.
  Result<Bytes> file = ReadFile("/dev/stdin", mesh::kMaxMeshFile);
  if (!file.ok()) return Fail(file.status().message());
  if (!ForbidSystem()) {
    return Fail(
        "expected a kernel that can confine the mesh reader (seccomp filters), found none: mesh "
        "files are not read unconfined; import on another machine and copy the scene's folder");
  }
  Result<mesh::NamedMesh> mesh = ReadMesh(*file, kind);
  if (!mesh.ok()) return Fail(mesh.status().message());
  return WriteAll(mesh::EncodeMesh(*mesh)) ? 0 : 1;
}

}  // namespace
}  // namespace enamel::import

int main(int argc, char** argv) {
  if (argc != 2) return enamel::import::Fail("usage: enamel-import-child KIND < FILE");
  try {
    return enamel::import::Run(argv[1]);
  } catch (const std::exception& e) {
    return enamel::import::Fail(std::string("cannot be read: ") + e.what());
  }
}
