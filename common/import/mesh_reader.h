#pragma once

#include <string>

#include "common/mesh/triangles.h"

namespace enamel::import {

// Parses a mesh file's bytes with the mesh library, in this process: only for the import child
// (child_main.cpp), which is confined, and the fuzzer. `kind` as for CheckMeshBytes. Polygons
// become fans of triangles; points and lines are left out; each mesh of the library becomes a part
// with the file's names for it. Errors: kInvalidInput and kTooLarge with the reason.
Result<mesh::NamedMesh> ReadMesh(ByteView file, const std::string& kind);

}  // namespace enamel::import
