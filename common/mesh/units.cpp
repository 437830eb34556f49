#include "common/mesh/units.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

namespace enamel::mesh {
namespace {

constexpr double kSmallest_mm = 3, kLargest_mm = 40;
// A file's rounding must not make 40.0000 mm too large.
constexpr double kRounding = 1e-5;  // of coordinates in a file
constexpr double kCoarsest_mm = 5e-3;

struct Unit {
  const char* name;
  double mm;
};
constexpr std::array<Unit, 5> kUnits = {
    {{"mm", 1}, {"um", 1e-3}, {"cm", 10}, {"m", 1000}, {"inch", 25.4}}};

Status Invalid(std::string message, std::string field) {
  return Status(Code::kInvalidInput, std::move(message), std::move(field));
}

bool IsToothSize(double extent_mm) {
  return extent_mm >= kSmallest_mm * (1 - kRounding) && extent_mm <= kLargest_mm * (1 + kRounding);
}

Status CheckFineness(const Box& box, double unit_mm) {
  double farthest = 0;
  for (int k = 0; k < 3; ++k)
    farthest = std::max({farthest, std::abs(box.lo[k]), std::abs(box.hi[k])});
  // A float's 24 bits.
  const double step_mm = farthest / (1 << 23);
  if (step_mm <= kCoarsest_mm) return Status::Ok();
  return Invalid("expected a tooth near its file's origin, found one " +
                     Fixed(farthest / unit_mm, 0) +
                     " units away, where coordinates come in steps of " + Fixed(1e3 * step_mm, 1) +
                     " um: move it to the origin in a mesh program",
                 "unit");
}

}  // namespace

Box BoxOf(const Triangles& mesh) {
  Box box;
  BoxOf(mesh.vertices, mesh.indices, box.lo, box.hi);
  return box;
}

std::string Fixed(double value, int digits) {
  char text[64];
  std::snprintf(text, sizeof text, "%.*f", digits, value);
  return text;
}

Result<double> UnitInMm(const std::string& name) {
  for (const Unit& u : kUnits) {
    if (name == u.name) return u.mm;
  }
  return Invalid("expected the unit mm, um, cm, m or inch, found '" + name + "'", "unit");
}

Status CheckSize(const Triangles& mesh_mm, const std::string& unit, double unit_mm) {
  const Box box = BoxOf(mesh_mm);
  const double extent = box.extent();
  if (IsToothSize(extent)) return CheckFineness(box, unit_mm);
  std::string fits;
  for (const Unit& u : kUnits) {
    if (IsToothSize(extent / unit_mm * u.mm))
      fits += (fits.empty() ? "" : " or ") + std::string(u.name);
  }
  return Invalid(
      "expected a tooth of 3 to 40 mm, found one of " + Fixed(extent, extent < 1 ? 4 : 2) +
          " mm with the unit '" + unit + "': " +
          (fits.empty() ? "no known unit makes it a tooth" : "its numbers look like " + fits),
      "unit");
}

}  // namespace enamel::mesh
