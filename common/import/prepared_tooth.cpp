#include "common/import/prepared_tooth.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include "common/import/child_process.h"
#include "common/import/printable.h"
#include "common/mesh/mesh_repair.h"
#include "common/mesh/triangle_tree.h"
#include "common/mesh/units.h"
#include "common/scene/builder.h"
#include "common/scene/volume_blob.h"
#include "common/surface/surface.h"

namespace enamel::import {
namespace {

using cutting::kBrickSide;
using cutting::kBrickVoxels;
using cutting::kPhiLimit;
using cutting::kPhiPerVoxel;
using mesh::Fixed;

constexpr double kOtherAsGood = 1.15;      // cost of another pose over the best one's
constexpr double kOtherAsExact = 1.25;     // and its RMS
constexpr double kMinDeep_mm = 0.06;       // shallower is no preparation but a scan's error
constexpr double kMinDeep_mm2 = 0.3;       // less is noise
constexpr double kAroundDeep_mm = 0.3;     // where the preparation runs out to the surface
constexpr double kSurelyGone_mm = 0.5;     // so far outside of the scan nothing agrees with it
constexpr double kMaxEdgeInside_mm = 0.5;  // of holes in the preparation
constexpr double kMinRemoved_mm3 = 0.05;
constexpr double kMaxRemovedShare = 0.7;

Status Invalid(const std::string& what, const char* field = "prepared") {
  return Status(Code::kInvalidInput, what, field);
}

std::string Percent(double share) { return Fixed(100 * share, 1) + " %"; }

// The scan as a solid, and which of its triangles a scanner saw.
struct Scan {
  mesh::Triangles whole, own, caps;
  size_t first_cap_vertex = 0;
};

Result<Scan> Close(const mesh::Triangles& mesh, const PreparedOptions& options,
                   std::vector<std::string>& report) {
  if (mesh.indices.empty()) return Invalid("the scan holds no triangles");
  ENAMEL_ASSIGN_OR_RETURN(const mesh::Triangles mesh_mm, mesh::InMm(mesh, options.scale));
  ENAMEL_ASSIGN_OR_RETURN(auto solid, mesh::MakeSolid(mesh_mm));
  report = Describe(solid.report);
  Scan out;
  out.first_cap_vertex = solid.first_cap_vertex;
  out.whole = std::move(solid.mesh);
  out.own.vertices = out.caps.vertices = out.whole.vertices;
  for (const auto& t : out.whole.indices) {
    const bool cap = std::max({t[0], t[1], t[2]}) >= solid.first_cap_vertex;
    (cap ? out.caps : out.own).indices.push_back(t);
  }
  return out;
}

Scan Moved(const Scan& scan, const mesh::Rigid& by) {
  return {mesh::Moved(scan.whole, by), mesh::Moved(scan.own, by), mesh::Moved(scan.caps, by),
          scan.first_cap_vertex};
}

mesh::Triangles Mirrored(mesh::Triangles mesh) {
  for (dvec3& v : mesh.vertices) v.x = -v.x;
  for (auto& t : mesh.indices) std::swap(t[1], t[2]);
  return mesh;
}

// Cells near which the scan lies deeper in the tooth than `deep_mm`.
class PreparedPlaces {
 public:
  PreparedPlaces(const cutting::Volume& tooth, const mesh::Triangles& own, double deep_mm) {
    const cutting::GridSpec& spec = tooth.spec();
    lo_ = spec.origin_m() * 1e3;
    size_ = ivec3(dvec3(spec.voxels()) * (spec.voxel_m() * 1e3 / kCell_mm)) + 2;
    marked_.resize(static_cast<size_t>(size_.x) * static_cast<size_t>(size_.y) *
                   static_cast<size_t>(size_.z));
    const auto count = static_cast<size_t>(4 * mesh::SurfaceArea(own) / (kCell_mm * kCell_mm));
    for (const mesh::SurfacePoint& point : mesh::SpreadOver(own, std::max<size_t>(count, 1))) {
      if (tooth.DistanceAt_m(point.at * 1e-3) > -1e-3 * deep_mm) continue;
      ++deep_points_;
      Mark(ivec3(glm::floor((point.at - lo_) / kCell_mm)));
    }
  }

  double area_mm2() const { return deep_points_ * kCell_mm * kCell_mm / 4; }
  bool At(const dvec3& p_mm) const {
    const ivec3 c(glm::floor((p_mm - lo_) / kCell_mm));
    return Contains(c) && marked_[IndexOf(c)];
  }

 private:
  static constexpr double kCell_mm = 0.1;
  static constexpr int kAround = static_cast<int>(kAroundDeep_mm / kCell_mm + 0.5);

  bool Contains(const ivec3& c) const {
    return c.x >= 0 && c.y >= 0 && c.z >= 0 && c.x < size_.x && c.y < size_.y && c.z < size_.z;
  }
  size_t IndexOf(const ivec3& c) const {
    return (static_cast<size_t>(c.z) * static_cast<size_t>(size_.y) + static_cast<size_t>(c.y)) *
               static_cast<size_t>(size_.x) +
           static_cast<size_t>(c.x);
  }
  void Mark(const ivec3& middle) {
    for (int z = -kAround; z <= kAround; ++z)
      for (int y = -kAround; y <= kAround; ++y)
        for (int x = -kAround; x <= kAround; ++x) {
          const ivec3 c = middle + ivec3(x, y, z);
          if (Contains(c)) marked_[IndexOf(c)] = true;
        }
  }

  dvec3 lo_;
  ivec3 size_{0};
  std::vector<bool> marked_;  // (z, y, x), x fastest
  double deep_points_ = 0;    // each for a quarter of a cell's face
};

// Length of the scan's edges and holes that lies deep in the tooth: where the preparation is, and
// not where the scan ends on the tooth's surface.
double EdgeInPreparation_mm(const Scan& scan, const cutting::Volume& tooth, double deep_mm) {
  auto deep = [&](const dvec3& p) { return tooth.DistanceAt_m(p * 1e-3) < -1e-3 * deep_mm; };
  double out = 0;
  for (const auto& t : scan.caps.indices) {
    // Two corners are on the rim, one is the cap's middle.
    std::array<dvec3, 2> rim;
    size_t found = 0;
    for (uint32_t v : t)
      if (v < scan.first_cap_vertex && found < 2) rim[found++] = scan.whole.vertices[v];
    if (found == 2 && deep(rim[0]) && deep(rim[1])) out += glm::length(rim[1] - rim[0]);
  }
  return out;
}

// The tooth with what lies outside of the scan gone.
class Carver {
 public:
  Carver(const cutting::Volume& tooth, const Scan& scan, const PreparedPlaces& places)
      : tooth_(tooth),
        places_(places),
        own_(scan.own),
        caps_(scan.caps),
        whole_(scan.whole),
        probe_(whole_, whole_),
        h_mm_(tooth.spec().voxel_m() * 1e3) {}

  cutting::Volume Carve() {
    const cutting::GridSpec& spec = tooth_.spec();
    cutting::Volume out(spec);
    for (int z = 0; z < spec.bricks.z; ++z)
      for (int y = 0; y < spec.bricks.y; ++y)
        for (int x = 0; x < spec.bricks.x; ++x) CarveBrick({x, y, z}, out);
    return out;
  }

 private:
  // How far outside of the scan a point is, where it has gone; nothing where it stays as it was.
  // + outside, - inside of it.
  double Gone_mm(const dvec3& p) {
    const double side = probe_.Distance(p, kFar_mm);
    const double own = own_.Distance(p, kFar_mm, &own_nearest_);
    // Nearer to a cap, or to the rim that it shares: beyond the end of the scan.
    if (own >= kFar_mm ||
        (!caps_.empty() && caps_.Distance(p, kFar_mm, &cap_nearest_) <= own + 1e-6)) {
      return -kFar_mm;
    }
    const double signed_mm = side < 0 ? -own : own;
    if (signed_mm > kSurelyGone_mm) return signed_mm;
    return places_.At(own_.NearestOn(own_nearest_, p)) ? signed_mm : -kFar_mm;
  }

  void CarveBrick(const ivec3& at, cutting::Volume& out) {
    const cutting::GridSpec& spec = tooth_.spec();
    const int brick = spec.BrickIndex(at);
    const bool air =
        !tooth_.IsStored(brick) && tooth_.UniformTissue(brick) == cutting::Tissue::kAir;
    const dvec3 corner = (spec.origin_m() + spec.voxel_m() * kBrickSide * dvec3(at)) * 1e3;
    const double reach = (0.5 * (kBrickSide - 1) * std::sqrt(3.0) + 4) * h_mm_;
    if (air || probe_.Distance(corner + 3.5 * h_mm_, kFar_mm) < -reach) {
      return scene::CopyBrick(tooth_, brick, out);
    }
    std::span<const uint8_t> labels;
    if (tooth_.HasLabels(brick)) labels = tooth_.Labels(brick).tissue;
    const auto uniform = static_cast<uint8_t>(tooth_.UniformTissue(brick));
    std::array<int16_t, kBrickVoxels> phi;
    bool changed = false, solid = false;
    for (int i = 0; i < kBrickVoxels; ++i) {
      const dvec3 p = corner + h_mm_ * dvec3(i & 7, i >> 3 & 7, i >> 6);
      const int before =
          tooth_.IsStored(brick) ? tooth_.Phi(brick).phi[static_cast<size_t>(i)] : -kPhiLimit;
      // Neighbours are not in the scan, and stay.
      const uint8_t tissue = labels.empty() ? uniform : labels[static_cast<size_t>(i)];
      const bool stays = tissue == static_cast<uint8_t>(cutting::Tissue::kNeighbour);
      const double gone =
          stays ? -kPhiLimit
                : std::clamp(Gone_mm(p) / h_mm_ * kPhiPerVoxel, -1.0 * kPhiLimit, 1.0 * kPhiLimit);
      const int after = std::max(before, static_cast<int>(std::lround(gone)));
      phi[static_cast<size_t>(i)] = static_cast<int16_t>(after);
      changed = changed || after != before;
      solid = solid || after < kPhiLimit;
    }
    if (!changed) return scene::CopyBrick(tooth_, brick, out);
    if (!solid) return;
    out.SetBrick(
        brick, phi, labels,
        labels.empty() ? tooth_.UniformTissue(brick) : static_cast<cutting::Tissue>(labels[0]));
  }

  static constexpr double kFar_mm = 30;

  const cutting::Volume& tooth_;
  const PreparedPlaces& places_;
  const mesh::TriangleTree own_, caps_, whole_;
  mesh::SignedProbe probe_;
  uint32_t own_nearest_ = 0, cap_nearest_ = 0;  // to the point before
  const double h_mm_;
};

// Voxel by voxel: a brick may hold both, where a neighbour touches.
cutting::Volume WithoutNeighbours(const cutting::Volume& tooth) {
  constexpr auto kNeighbour = cutting::Tissue::kNeighbour;
  cutting::Volume out(tooth.spec());
  const int bricks = static_cast<int>(tooth.spec().brick_count());
  for (int b = 0; b < bricks; ++b) {
    if (!tooth.HasLabels(b)) {
      if (tooth.UniformTissue(b) != kNeighbour) scene::CopyBrick(tooth, b, out);
      continue;
    }
    auto phi = tooth.Phi(b).phi;
    const auto& labels = tooth.Labels(b).tissue;
    for (size_t i = 0; i < phi.size(); ++i) {
      if (labels[i] == static_cast<uint8_t>(kNeighbour)) phi[i] = kPhiLimit;
    }
    out.SetBrick(b, phi, labels, static_cast<cutting::Tissue>(labels[0]));
  }
  return out;
}

// Share of what is not in the preparation, by distance: a histogram for people.
void DescribeDistances(const mesh::Fit& fit, std::vector<std::string>& report) {
  constexpr std::array kEdges_mm = {-0.15, -0.1, -0.06, -0.03, -0.01, 0.01, 0.03, 0.06, 0.1, 0.15};
  const auto count = static_cast<double>(fit.distance_mm.size());
  report.push_back("distance of the scan from the tooth, + outside, share of the scan:");
  auto line = [&](const std::string& name, double from, double to) {
    const auto n = std::count_if(fit.distance_mm.begin(), fit.distance_mm.end(),
                                 [&](double d) { return d >= from && d < to; });
    const double share = static_cast<double>(n) / count;
    report.push_back("  " + name + "  " + Percent(share) + "  " +
                     std::string(static_cast<size_t>(std::lround(60 * share)), '#'));
  };
  line("deeper than -0.15 mm", -1e9, kEdges_mm.front());
  for (size_t i = 0; i + 1 < kEdges_mm.size(); ++i) {
    line(Fixed(kEdges_mm[i]) + " to " + Fixed(kEdges_mm[i + 1]) + " mm", kEdges_mm[i],
         kEdges_mm[i + 1]);
  }
  line("farther out than 0.15 mm", kEdges_mm.back(), 1e9);
}

std::string Figures(const mesh::Fit& fit) {
  return Percent(fit.agree_share) + " of the scan agrees with the tooth, " +
         Percent(fit.inside_share) + " lies deeper, " + Percent(fit.outside_share) +
         " outside of it; of what is not deeper RMS " + Fixed(fit.rms_mm, 3) + " mm, p95 " +
         Fixed(fit.p95_mm, 3) + " mm";
}

Result<mesh::Fit> FindFit(const cutting::Volume& tooth, const Scan& scan, bool placed) {
  const mesh::Triangles surface = ToothSurface_mm(tooth);
  std::vector<mesh::Fit> fits;
  if (placed) {
    fits.push_back(mesh::FitNear(surface, scan.own));
  } else {
    fits = mesh::FitOnto(surface, scan.own);
  }
  Status status = CheckFit(fits);
  if (status.ok()) return fits.front();
  if (!placed && CheckFit(mesh::FitOnto(surface, Mirrored(scan.own))).ok()) {
    return Invalid(
        "the scan is the mirror image of this tooth: it is of the other side of the mouth, or was "
        "mirrored on its way; choose that side's tooth, or mirror the scan in x");
  }
  return status;
}

scene::Scene Described(const scene::Scene& scene, const cutting::Volume& volume,
                       const std::string& source, const mesh::Fit& fit) {
  scene::Scene out = scene;
  out.name = (scene.name.substr(0, 55) + "-prepared");
  out.title = (scene.title.substr(0, 180) + ", prepared");
  out.preparations.clear();
  out.volume = HashSha256(scene::EncodeVolume(volume));
  const auto volumes = cutting::SolidVolume_m3(volume);
  std::erase_if(out.tissues, [&](const scene::TissueSpec& t) {
    return volumes[static_cast<size_t>(t.tissue)] <= 0;
  });
  out.provenance =
      "prepared tooth, " + source + ", laid on " + scene.volume.Hex() + ": " + Figures(fit);
  return out;
}

}  // namespace

mesh::Triangles ToothSurface_mm(const cutting::Volume& tooth) {
  const surface::Mesh mesh = surface::ExtractSurface(WithoutNeighbours(tooth));
  mesh::Triangles out;
  out.vertices.reserve(mesh.position_m.size());
  for (const glm::vec3& p : mesh.position_m) out.vertices.push_back(dvec3(p) * 1e3);
  out.indices = mesh.triangles;
  return out;
}

Status CheckFit(const std::vector<mesh::Fit>& fits) {
  if (fits.empty()) {
    return Invalid(
        "nothing of the scan agrees with the tooth: is it a scan of this tooth, and is "
        "--unit right?");
  }
  const mesh::Fit& fit = fits.front();
  std::string why;
  auto add = [&](const std::string& text) { why += (why.empty() ? "" : ", ") + text; };
  const bool collar = fit.agree_share >= kMinCollar && fit.rms_mm <= kCollarRms_mm &&
                      fit.p95_mm <= kCollarP95_mm && fit.outside_share <= kCollarOutside;
  if (fit.agree_share < kMinAgree && !collar) {
    add("at least " + Percent(kMinAgree) +
        " has to agree, as what was not prepared holds the "
        "scan in its place");
  }
  if (fit.outside_share > kMaxOutside) {
    add("at most " + Percent(kMaxOutside) + " may lie outside, as nothing grows on a tooth");
  }
  if (fit.rms_mm > kMaxRms_mm) add("the RMS may be at most " + Fixed(kMaxRms_mm) + " mm");
  if (fit.p95_mm > kMaxP95_mm) add("the p95 may be at most " + Fixed(kMaxP95_mm) + " mm");
  if (!why.empty()) {
    return Invalid("the scan does not fit this tooth: " + Figures(fit) + ". Expected: " + why +
                   ". Is it a scan of this tooth, whole around the preparation, and is --unit "
                   "right?");
  }
  // A fit that is less exact is no rival: it is the crown slid along its own reduction.
  const auto rival = std::find_if(fits.begin() + 1, fits.end(), [&](const mesh::Fit& other) {
    return other.cost < kOtherAsGood * fit.cost + 0.002 && other.outside_share <= kMaxOutside &&
           other.rms_mm < kOtherAsExact * fit.rms_mm + 0.005;
  });
  if (rival != fits.end()) {
    return Invalid("the scan fits the tooth in two ways that are equally good, " +
                   Fixed(mesh::TurnOf_deg(rival->fixed_from_moving.rotation *
                                          glm::transpose(fit.fixed_from_moving.rotation)),
                         0) +
                   " degrees apart: turn it in its file to where it belongs and use --placed");
  }
  return Status::Ok();
}

Result<PreparedTooth> TakePrepared(const scene::Scene& scene, const cutting::Volume& tooth,
                                   const mesh::Triangles& mesh, const std::string& source,
                                   const PreparedOptions& options) {
  PreparedTooth out;
  std::vector<std::string>& report = out.prepared.report;
  ENAMEL_ASSIGN_OR_RETURN(const Scan read, Close(mesh, options, report));
  ENAMEL_ASSIGN_OR_RETURN(out.fit, FindFit(tooth, read, options.placed));
  const Scan scan = Moved(read, out.fit.fixed_from_moving);
  // Distances in the tooth end at four voxels.
  const double h_mm = tooth.spec().voxel_m() * 1e3;
  const double deep_mm =
      std::min(std::clamp(5 * out.fit.rms_mm, kMinDeep_mm, mesh::kAgree_mm), 3.5 * h_mm);
  const PreparedPlaces places(tooth, scan.own, deep_mm);
  if (places.area_mm2() < kMinDeep_mm2) {
    return Invalid("the scan shows no preparation: " + Fixed(places.area_mm2()) +
                   " mm2 of it are deeper than " + Fixed(deep_mm) + " mm in the tooth");
  }
  if (const double edge = EdgeInPreparation_mm(scan, tooth, deep_mm); edge > kMaxEdgeInside_mm) {
    return Invalid(
        "the preparation is not whole: " + Fixed(edge, 1) +
        " mm of the scan's edge or of a hole are inside it; scan the whole preparation again");
  }
  out.prepared.volume = Carver(tooth, scan, places).Carve();
  const auto before = cutting::SolidVolume_m3(tooth),
             after = cutting::SolidVolume_m3(out.prepared.volume);
  double whole_mm3 = 0;
  for (size_t t = 0; t < before.size(); ++t) {
    out.removed_mm3 += (before[t] - after[t]) * 1e9;
    if (static_cast<cutting::Tissue>(t) != cutting::Tissue::kNeighbour)
      whole_mm3 += before[t] * 1e9;
  }
  if (out.removed_mm3 < kMinRemoved_mm3 || out.removed_mm3 > kMaxRemovedShare * whole_mm3) {
    return Invalid("the scan lacks " + Fixed(out.removed_mm3) + " mm3 of the tooth's " +
                   Fixed(whole_mm3, 0) + " mm3: expected a preparation of " +
                   Fixed(kMinRemoved_mm3) + " mm3 to " + Percent(kMaxRemovedShare) + " of it");
  }
  report.push_back(Figures(out.fit));
  DescribeDistances(out.fit, report);
  report.push_back("the preparation is " + Fixed(out.removed_mm3) + " mm3");
  out.prepared.scene = Described(scene, out.prepared.volume, source, out.fit);
  return out;
}

Result<PreparedTooth> TakePrepared(const scene::Scene& scene, const cutting::Volume& tooth,
                                   const std::filesystem::path& file,
                                   const PreparedOptions& options,
                                   const std::filesystem::path& child) {
  ENAMEL_ASSIGN_OR_RETURN(auto read, ReadMeshInChild(file, child));
  const std::string source = "scanned as " + Printable(file.filename().string()) + " (SHA-256 " +
                             read.sha256.Hex() + ", " + mesh::Words(options.scale) + ")";
  auto out = TakePrepared(scene, tooth, read.mesh.mesh, source, options);
  if (out.ok()) {
    std::vector<std::string>& report = out->prepared.report;
    report.insert(report.begin(), read.mesh.notes.begin(), read.mesh.notes.end());
    return out;
  }
  const Status& why = out.status();
  return Status(why.code(), Printable(file.filename().string()) + ": " + why.message(),
                why.field());
}

}  // namespace enamel::import
