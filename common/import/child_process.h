#pragma once

#include <filesystem>

#include "common/base/result.h"
#include "common/base/sha256.h"
#include "common/mesh/triangles.h"

namespace enamel::import {

// Reads a mesh file in a child process with limits (child_main.cpp) and checks what comes back.
// `child` empty: enamel-import-child beside the running program. Blocks for at most 90 s.
// Errors: kNotFound (file or child missing), kInvalidInput with the reader's reason, kTooLarge,
// kUnavailable when the child was killed by a limit.
struct ReadFileMesh {
  mesh::NamedMesh mesh;
  Sha256 sha256;  // of the very bytes the mesh was made from
};
Result<ReadFileMesh> ReadMeshInChild(const std::filesystem::path& file,
                                     const std::filesystem::path& child = {});

}  // namespace enamel::import
