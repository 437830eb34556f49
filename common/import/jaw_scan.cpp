#include "common/import/jaw_scan.h"

#include <algorithm>
#include <string>
#include <utility>

#include "common/import/child_process.h"
#include "common/import/printable.h"
#include "common/mesh/cut_out.h"
#include "common/mesh/mesh_repair.h"

namespace enamel::import {
namespace {

// A bur's head and the play of a hand: farther off a neighbour is not met.
constexpr double kAround_mm = 2;

Status Invalid(const std::string& message) {
  return Status(Code::kInvalidInput, message, "around");
}

std::string NameOf(size_t curve) {
  return curve == 0 ? "the tooth's curve" : "the curve of neighbour " + std::to_string(curve);
}

class BesideField : public scene::BrickField {
 public:
  BesideField(std::unique_ptr<scene::BrickField> tooth, const NeighbourTeeth& neighbours,
              const mesh::Box& box)
      : tooth_(std::move(tooth)), box_(box) {
    for (const auto& n : neighbours) beside_.push_back({n.get(), {n->boundary(), n->whole()}});
  }

  scene::FieldSample At(const dvec3& point_m, double reach_m) override {
    scene::FieldSample out = tooth_->At(point_m, reach_m);
    for (Beside& b : beside_) Join(b, point_m, reach_m, out);
    return out;
  }
  void Brick(const dvec3& corner_m, double voxel_m, double reach_m, Samples& out) override {
    tooth_->Brick(corner_m, voxel_m, reach_m, out);
    const dvec3 lo = corner_m * 1e3, hi = lo + (cutting::kBrickSide - 1) * voxel_m * 1e3;
    for (Beside& b : beside_) {
      const mesh::Box& box = b.tooth->box();
      const dvec3 gap = glm::max(dvec3(0), glm::max(box.lo - hi, lo - box.hi));
      if (glm::length(gap) >= reach_m * 1e3) continue;
      for (int i = 0; i < cutting::kBrickVoxels; ++i) {
        Join(b, corner_m + voxel_m * dvec3(i % 8, i / 8 % 8, i / 64), reach_m,
             out[static_cast<size_t>(i)]);
      }
    }
  }

 private:
  struct Beside {
    const NeighbourTooth* tooth;
    mesh::SignedProbe probe;
  };
  void Join(Beside& beside, const dvec3& point_m, double reach_m, scene::FieldSample& out) const {
    const dvec3 p = point_m * 1e3;
    const dvec3 off = glm::max(box_.lo - p, p - box_.hi);
    const double d_m =
        1e-3 * std::max({beside.probe.Distance(p, reach_m * 1e3), off.x, off.y, off.z});
    // Another tissue begins where the neighbour does.
    out.tissue_margin_m = std::min(out.tissue_margin_m, std::max(d_m, 0.0));
    if (out.distance_m < 0 || d_m >= out.distance_m) return;
    out = {d_m, cutting::Tissue::kNeighbour, 0};
  }

  std::unique_ptr<scene::BrickField> tooth_;
  const mesh::Box box_;
  std::vector<Beside> beside_;
};

}  // namespace

Result<CutCrowns> CutOut(const mesh::Triangles& scan, const mesh::FileScale& scale,
                         const GumCurves& around) {
  if (around.size() > kMaxGumCurves) {
    return Invalid(
        "expected a curve around the tooth and at most two around its neighbours, found " +
        std::to_string(around.size()) + " curves");
  }
  ENAMEL_ASSIGN_OR_RETURN(const mesh::Triangles scan_mm, mesh::InMm(scan, scale, mesh::kScan));
  const mesh::Jaw jaw(scan_mm);
  CutCrowns out;
  for (size_t i = 0; i < around.size(); ++i) {
    Result<mesh::Triangles> crown = jaw.Crown(around[i]);
    if (!crown.ok()) return Invalid(NameOf(i) + ": " + crown.status().message());
    if (const double size_mm = mesh::BoxOf(*crown).extent();
        size_mm < mesh::kTooth.min_mm || size_mm > mesh::kTooth.max_mm) {
      return Invalid(NameOf(i) + ": expected a crown of " + mesh::Fixed(mesh::kTooth.min_mm, 0) +
                     " to " + mesh::Fixed(mesh::kTooth.max_mm, 0) + " mm inside it, found " +
                     mesh::Fixed(size_mm, 1) + " mm: draw it around one tooth, along its gum");
    }
    if (i == 0) {
      out.tooth = *std::move(crown);
    } else {
      out.neighbours.push_back(*std::move(crown));
    }
  }
  return out;
}

Result<mesh::Triangles> ReadJawScan(const std::filesystem::path& file, const mesh::FileScale& scale,
                                    const std::filesystem::path& child) {
  ENAMEL_ASSIGN_OR_RETURN(const ReadFileMesh read, ReadMeshInChild(file, child));
  const std::string name = Printable(file.filename().string());
  if (read.mesh.mesh.indices.empty())
    return Status(Code::kInvalidInput, name + ": the mesh holds no triangles");
  auto scan = mesh::InMm(read.mesh.mesh, scale, mesh::kScan);
  if (!scan.ok())
    return Status(scan.status().code(), name + ": " + scan.status().message(),
                  scan.status().field());
  return mesh::Welded(*scan);
}

Result<std::unique_ptr<NeighbourTooth>> NeighbourTooth::Make(const mesh::Triangles& crown,
                                                             const PlacedSolid& beside) {
  mesh::Triangles placed = crown;
  for (dvec3& v : placed.vertices) v = beside.turn * v - beside.middle;
  ENAMEL_ASSIGN_OR_RETURN(const mesh::Solid solid, mesh::MakeSolid(placed));
  return std::unique_ptr<NeighbourTooth>(new NeighbourTooth(solid));
}

mesh::Box BoxWith(const mesh::Box& tooth, const NeighbourTeeth& neighbours) {
  mesh::Box all = tooth;
  for (const auto& n : neighbours) {
    all.lo = glm::min(all.lo, n->box().lo);
    all.hi = glm::max(all.hi, n->box().hi);
  }
  return {glm::max(all.lo, tooth.lo - kAround_mm), glm::min(all.hi, tooth.hi + kAround_mm)};
}

std::unique_ptr<scene::BrickField> FieldWith(std::unique_ptr<scene::BrickField> tooth,
                                             const NeighbourTeeth& neighbours,
                                             const mesh::Box& box) {
  if (neighbours.empty()) return tooth;
  return std::make_unique<BesideField>(std::move(tooth), neighbours, box);
}

}  // namespace enamel::import
