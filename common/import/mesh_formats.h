#pragma once

#include "common/base/bytes.h"
#include "common/import/mesh_builder.h"

// One bounded reader for each mesh format. None takes memory of a size that a file only claims, and
// each refusal names what the file says, what was found and what to do. Errors: kInvalidInput,
// kTooLarge.
namespace enamel::import {

// Binary: 80 bytes, u32 count, 50 bytes each (StereoLithography Interface Specification, 3D Systems
// 1988). Fewer bytes than the count says are refused, and so are more that are triangles; other
// bytes at the end are left out with a note. Text: keywords in any case, begins with "solid" after
// any blank lines, ends with "endsolid". Normals are not read.
Status ReadStl(ByteView file, MeshBuilder& out);
// Text and binary of both byte orders (G. Turk, "The PLY Polygon File Format", 1994): elements
// "vertex", "face" and "tristrips" in any order; all others are passed over.
Status ReadPly(ByteView file, MeshBuilder& out);
// v, f, o, g, usemtl; lines may continue with a backslash. Libraries of materials are not opened.
Status ReadObj(ByteView file, MeshBuilder& out);
// Text, with any letters before OFF (colours, normals).
Status ReadOff(ByteView file, MeshBuilder& out);

}  // namespace enamel::import
