#pragma once

#include <string_view>

#include "common/base/bytes.h"
#include "common/base/result.h"

namespace enamel::import {

// Checks a mesh file before a mesh library reads it: counts that the file cannot hold or that are
// above the limits, and files that were cut short. `kind` is the file's extension in small letters
// without the dot: stl, ply, obj, off; others pass. One pass over the bytes, no memory of the size
// that a file claims. Errors: kInvalidInput, kTooLarge; each gives the file's claim, the finding
// and what to do.
//
// STL, binary: 80 bytes, u32 count, 50 bytes each (as used since the StereoLithography Interface
// Specification, 3D Systems 1988): the count must match the size. STL, text: ends with "endsolid".
// PLY (G. Turk, "The PLY Polygon File Format", 1994): the header's elements, list by list, are all
// there, and little follows them. OBJ: number of triangles, and no last line with half a face. OFF:
// as many numbers as its counts promise, and indices below them.
Status CheckMeshBytes(ByteView file, std::string_view kind);

}  // namespace enamel::import
