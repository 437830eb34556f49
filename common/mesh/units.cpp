#include "common/mesh/units.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

namespace enamel::mesh {
namespace {

// A file's rounding must not make 40.0000 mm too large.
constexpr double kRounding = 1e-5;  // of coordinates in a file
constexpr double kCoarsest_mm = 5e-3;
constexpr double kSmallestFactor = 1e-6;

struct Unit {
  const char* name;
  double mm;
};
constexpr std::array<Unit, 5> kUnits = {
    {{"mm", 1}, {"um", 1e-3}, {"cm", 10}, {"m", 1000}, {"inch", 25.4}}};

Status Invalid(std::string message, std::string field) {
  return Status(Code::kInvalidInput, std::move(message), std::move(field));
}

bool Fits(double extent_mm, const Sized& sized) {
  return extent_mm >= sized.min_mm * (1 - kRounding) && extent_mm <= sized.max_mm * (1 + kRounding);
}

// The coarsest step between coordinates of a mesh: what a float far from 0 cannot tell apart. A
// file that holds doubles is finer, wherever it lies.
double Step(const Triangles& mesh, double farthest) {
  for (const dvec3& v : mesh.vertices) {
    for (int k = 0; k < 3; ++k) {
      if (static_cast<double>(static_cast<float>(v[k])) != v[k]) return farthest * 0x1p-52;
    }
  }
  return farthest * 0x1p-23;
}

Status CheckFineness(const Triangles& mesh, const Box& box, double scale_mm, const Sized& sized) {
  double farthest = 0;
  for (int k = 0; k < 3; ++k)
    farthest = std::max({farthest, std::abs(box.lo[k]), std::abs(box.hi[k])});
  const double step_mm = scale_mm * Step(mesh, farthest);
  if (step_mm <= kCoarsest_mm) return Status::Ok();
  return Invalid(std::string("expected a ") + sized.what + " near its file's origin, found one " +
                     Fixed(farthest, 0) + " units away, where coordinates come in steps of " +
                     Fixed(1e3 * step_mm, 1) + " um: move it to the origin in a mesh program",
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

std::string Words(const FileScale& scale) {
  char text[64];
  if (scale.longest_mm > 0) {
    std::snprintf(text, sizeof text, "longest side %.9g mm", scale.longest_mm);
    return text;
  }
  std::snprintf(text, sizeof text, ", scale %.9g", scale.factor);
  return "unit " + scale.unit + (scale.factor == 1 ? "" : text);
}

Status CheckScale(const FileScale& scale) {
  ENAMEL_RETURN_IF_ERROR(UnitInMm(scale.unit).status());
  if (scale.longest_mm != 0 && !Fits(scale.longest_mm, {"", kTooth.min_mm, kScan.max_mm})) {
    return Invalid("expected a longest side of 3 mm (a tooth) to 200 mm (a jaw), found " +
                       Fixed(scale.longest_mm) + " mm",
                   "longest_mm");
  }
  if (std::isfinite(scale.factor) && scale.factor >= kSmallestFactor &&
      scale.factor <= 1 / kSmallestFactor)
    return Status::Ok();
  return Invalid("expected a scale of 0.000001 to 1000000, found " + Fixed(scale.factor, 6),
                 "scale");
}

Result<double> ScaleInMm(const Triangles& mesh, const FileScale& scale) {
  ENAMEL_RETURN_IF_ERROR(CheckScale(scale));
  if (scale.longest_mm == 0) return *UnitInMm(scale.unit) * scale.factor;
  const double extent = BoxOf(mesh).extent();
  if (extent > 0) return scale.longest_mm / extent;
  return Invalid("expected a mesh with an extent, found all of it in one point", "longest_mm");
}

Status CheckSize(const Triangles& mesh, const FileScale& scale, const Sized& sized) {
  ENAMEL_ASSIGN_OR_RETURN(const double scale_mm, ScaleInMm(mesh, scale));
  const Box box = BoxOf(mesh);
  const double extent = box.extent(), extent_mm = extent * scale_mm;
  if (Fits(extent_mm, sized)) return CheckFineness(mesh, box, scale_mm, sized);
  const bool by_length = scale.longest_mm > 0;
  std::string fits;
  for (const Unit& u : kUnits) {
    if (!by_length && Fits(extent * u.mm * scale.factor, sized))
      fits += (fits.empty() ? "" : " or ") + std::string(u.name);
  }
  std::string what = std::string("expected a ") + sized.what + " of " + Fixed(sized.min_mm, 0) +
                     " to " + Fixed(sized.max_mm, 0) + " mm, found one of " +
                     Fixed(extent_mm, extent_mm < 1 ? 4 : 2) + " mm";
  what += by_length ? " by its longest side"
                    : " with the unit '" + scale.unit + "'" +
                          (scale.factor == 1 ? "" : " and the scale " + Fixed(scale.factor, 6));
  if (!fits.empty()) return Invalid(what + ": its numbers look like " + fits, "unit");
  if (Fits(extent_mm, kScan))
    what += "; one tooth can be cut out of a scan of several teeth on the server's page";
  if (by_length) return Invalid(what, "longest_mm");
  return Invalid(what + "; no known unit makes it a " + sized.what +
                     ": where you know how long it is, give its longest side in mm",
                 "unit");
}

Result<Triangles> InMm(const Triangles& mesh, const FileScale& scale, const Sized& sized) {
  ENAMEL_RETURN_IF_ERROR(CheckSize(mesh, scale, sized));
  ENAMEL_ASSIGN_OR_RETURN(const double scale_mm, ScaleInMm(mesh, scale));
  Triangles out = mesh;
  for (dvec3& v : out.vertices) v *= scale_mm;
  return out;
}

}  // namespace enamel::mesh
