#pragma once

#include <array>
#include <string>
#include <string_view>

#include "common/base/bytes.h"
#include "common/base/result.h"

namespace enamel::import {

// The formats that are read, by a file name's end in small letters without the dot.
inline constexpr std::array<std::string_view, 4> kMeshKinds = {"stl", "ply", "obj", "off"};

// Errors: kInvalidInput for a name's end that no reader is for; says how to export the formats that
// scanners and laboratories use.
Status CheckMeshKind(std::string_view kind);

// What a file's first bytes show that it is, whatever its name says: one of kMeshKinds; empty where
// they show nothing (an OBJ file and a binary STL begin with anything). Errors: kInvalidInput for
// what is no mesh that is read (ZIP, glTF, DICOM, 3Shape's DCM, ...), with what to do.
Result<std::string> KindInside(ByteView file);

}  // namespace enamel::import
