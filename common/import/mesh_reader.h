#pragma once

#include <string>

#include "common/mesh/triangles.h"

namespace enamel::import {

// Parses a mesh file's bytes in this process: only for the import child (child_main.cpp), which is
// confined, tests and the fuzzer. `kind` is one of kMeshKinds; what the bytes show goes before it.
// Polygons become triangles; points and lines are left out; a part carries the file's names for it.
// Errors: kInvalidInput and kTooLarge with the reason.
Result<mesh::NamedMesh> ReadMesh(ByteView file, const std::string& kind);

}  // namespace enamel::import
