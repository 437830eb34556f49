#pragma once

#include <string>

#include "common/mesh/triangles.h"

namespace enamel::mesh {

struct Box {
  dvec3 lo, hi;
  dvec3 size() const { return hi - lo; }
  double extent() const { return glm::max(size().x, glm::max(size().y, size().z)); }
};
// The box of the vertices that the triangles use. Requires: at least one.
Box BoxOf(const Triangles& mesh);

// Millimetres in one mm, um, cm, m, inch. Errors: kInvalidInput, field "unit".
Result<double> UnitInMm(const std::string& name);

// The size of a file's coordinates: a unit, and how many of it 1 is; or the length of the longest
// side of the box around everything in the file, along the file's axes, which then decides alone.
struct FileScale {
  std::string unit = "mm";
  double factor = 1;
  double longest_mm = 0;  // 0: not known
};
std::string Words(const FileScale& scale);
// Errors: kInvalidInput, field "unit", "scale" or "longest_mm".
Status CheckScale(const FileScale& scale);
// Millimetres in 1 of the mesh's coordinates. Errors: CheckScale's, and a mesh without extent.
Result<double> ScaleInMm(const Triangles& mesh, const FileScale& scale);

// The expected content of a file, by the longest side of its box.
struct Sized {
  const char* what;
  double min_mm, max_mm;
};
inline constexpr Sized kTooth{"tooth", 3, 40};
// A jaw's scan is some 70 mm wide; a sextant is 20 mm.
inline constexpr Sized kScan{"scan of several teeth", 3, 200};

// In millimetres, a mesh in a file's coordinates. Coordinates that are all floats carry 24 bits, so a tooth far from the
// origin is coarse: steps over 5 um are refused.
// Errors: ScaleInMm's, and kInvalidInput, field "unit"; the message names the units that would fit.
Status CheckSize(const Triangles& mesh, const FileScale& scale, const Sized& sized = kTooth);
Result<Triangles> InMm(const Triangles& mesh, const FileScale& scale, const Sized& sized = kTooth);

// "12.35": a number for people.
std::string Fixed(double value, int digits = 2);

}  // namespace enamel::mesh
