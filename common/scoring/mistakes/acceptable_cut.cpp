#include "common/scoring/mistakes/acceptable_cut.h"

#include <algorithm>
#include <cmath>

#include "common/math/ramp.h"
#include "common/scoring/brick_samples.h"
#include "common/scoring/changed.h"
#include "common/scoring/mistakes/cut_surface.h"
#include "common/scoring/task.h"
#include "common/scoring/uncertainty.h"

namespace enamel::scoring {
namespace {

// The triangles with all of their corners cut. Then, if asked for, those at the rim, which reach out onto the tooth
// and face as it does.
surface::Mesh CutSurfaceOf(const surface::Mesh& mesh, const std::vector<bool>& cut, bool rim) {
  surface::Mesh out = mesh;
  auto corners = [&](const auto& t) { return cut[t[0]] + cut[t[1]] + cut[t[2]]; };
  std::erase_if(out.triangles, [&](const auto& t) { return corners(t) < 3; });
  for (const auto& t : mesh.triangles) {
    if (rim && corners(t) > 0 && corners(t) < 3) out.triangles.push_back(t);
  }
  return out;
}

}  // namespace

double Layer::Moment_m2() const {
  const double a = std::max(0.0, from_m - kLeeway_m), b = std::max(0.0, to_m - kLeeway_m);
  return thickness_m() > 0 ? (b * b * b - a * a * a) / (3 * thickness_m()) : 0;
}

double Layer::Beyond() const {
  if (from_m >= kLeeway_m) return 1;
  return to_m <= kLeeway_m ? 0 : (to_m - kLeeway_m) / thickness_m();
}

std::string_view NameOf(RegionKind kind) {
  constexpr std::array<std::string_view, kRegionKinds> kNames = {
      "floor", "wall", "table", "axial_wall", "margin", "face", "line_angle"};
  return kNames[static_cast<size_t>(kind)];
}

AcceptableCut::AcceptableCut(const cutting::Volume& initial, const cutting::Volume& prepared,
                             const ToothPlace& place)
    : initial_(initial), prepared_(prepared) {
  const surface::Mesh mesh = surface::ExtractSurface(prepared);
  const std::vector<bool> is_cut = CutVertices(mesh, initial, prepared);
  const surface::Mesh inner = CutSurfaceOf(mesh, is_cut, false);
  const surface::Mesh whole = CutSurfaceOf(mesh, is_cut, true);
  surface_ = std::make_unique<CutSurface>(DivideSurface(inner, place));
  edges_ = QueryOf(inner, [this](size_t i) { return surface_->edge_piece[i] != kNoPiece; });
  for (const uint32_t piece : surface_->edge_piece) {
    if (piece != kNoPiece) piece_of_edge_.push_back(piece);
  }
  query_.emplace(whole);
  MarkRim(whole, inner.triangles.size());
  const surface::DistanceQuery inner_query(inner);
  for (uint32_t i = 0; i < whole.triangles.size(); ++i) {
    if (i < inner.triangles.size()) {
      inner_.push_back(i);
      continue;
    }
    dvec3 middle(0);
    for (const uint32_t v : whole.triangles[i]) middle += dvec3(whole.position_m[v]) / 3.0;
    const auto nearest = inner_query.NearestTriangle(middle, kDeepest_m);
    inner_.push_back(nearest ? nearest->triangle : 0);
  }
  if (!is_stump()) contact_.emplace(initial, prepared, place.tooth, place.up);
  if (contact_ && contact_->thirds().empty()) contact_.reset();
  MeasureTask();
  FindPulp();
  surface_u_m_ = SurfaceUncertainty_m(initial_.spec().voxel_m(), place.registration_m);
}

void AcceptableCut::FindPulp() {
  const double step_m = 0.25 * initial_.spec().voxel_m();
  double cover_m = kPulpCover_m;
  for (const SurfacePiece& piece : pieces()) {
    for (double in_m = 0; in_m < cover_m; in_m += step_m) {
      if (initial_.TissueAtPoint(piece.at_m - piece.normal * in_m) == cutting::Tissue::kPulp)
        cover_m = in_m;
    }
  }
  pulp_counts_ = Ramp(cover_m, kLeeway_m, kPulpCover_m);
}

void AcceptableCut::MarkRim(const surface::Mesh& whole, size_t inner) {
  std::vector<bool> rim(whole.position_m.size());
  for (size_t i = inner; i < whole.triangles.size(); ++i) {
    for (const uint32_t v : whole.triangles[i]) rim[v] = true;
  }
  for (const auto& t : whole.triangles) at_rim_.push_back(rim[t[0]] || rim[t[1]] || rim[t[2]]);
}

AcceptableCut::~AcceptableCut() = default;

const std::vector<Region>& AcceptableCut::regions() const { return surface_->regions; }
const std::vector<SurfacePiece>& AcceptableCut::pieces() const { return surface_->pieces; }
bool AcceptableCut::is_stump() const { return surface_->is_stump; }

std::optional<AcceptableCut::Found> AcceptableCut::NearestTo(const dvec3& point_m, double limit_m,
                                                             Guess& guess) const {
  if (surface_->pieces.empty()) return {};
  const auto found = query_->NearestTriangle(point_m, limit_m, guess.triangle);
  if (!found) return {};
  guess.triangle = found->triangle;
  const uint32_t inner = inner_[found->triangle];
  const uint32_t piece = surface_->piece[inner];
  Found out{{found->distance_m, piece, piece}, found->triangle};
  if (surface_->beside[inner] != kNoPiece) {
    out.nearest.beside = surface_->beside[inner];
    out.nearest.beside_share = surface_->beside_share[inner];
  }
  if (!edges_) return out;
  double other_m = found->distance_m + kLineAngle_m + kLineAngleSoft_m;
  const double farthest_m = other_m;
  const auto& meets = surface_->meets[surface_->family[inner]];
  for (size_t other = 0; other < meets.size(); ++other) {
    if (!meets[other]) continue;
    const auto& query = surface_->of_family[other];
    other_m = query->Distance_m(point_m, other_m);
  }
  if (!(other_m < farthest_m)) return out;
  // The edge is at most as far again.
  const auto edge = edges_->NearestTriangle(point_m, 2 * farthest_m, guess.edge);
  if (!edge) return out;
  guess.edge = edge->triangle;
  out.nearest.edge = piece_of_edge_[edge->triangle];
  out.nearest.edge_share = Ramp(farthest_m - other_m, 0, 2 * kLineAngleSoft_m);
  return out;
}

AcceptableCut::Brick::Brick(const AcceptableCut& r, int brick, double limit_m)
    : r_(r),
      limit_m_(limit_m),
      voxel_m_(r.initial_.spec().voxel_m()),
      samples_(r.prepared_.Samples(brick)) {
  const cutting::GridSpec& spec = r.initial_.spec();
  const ivec3& n = spec.bricks;
  const ivec3 at(brick % n.x, brick / n.x % n.y, brick / (n.x * n.y));
  first_m_ = spec.origin_m() + dvec3(at * cutting::kBrickSide) * voxel_m_;
  if (voxel_m_ <= 0.05e-3) side_ = 4;
}

dvec3 AcceptableCut::Brick::PointOf(int i) const {
  return first_m_ + dvec3(i & 7, i >> 3 & 7, i >> 6) * voxel_m_;
}

std::optional<AcceptableCut::Nearest> AcceptableCut::Brick::At(int i) {
  // Faults near R's surface are looked up voxel by voxel. Farther away one triangle answers for a block.
  constexpr double kFar_m = 1e-3;
  const ivec3 at = ivec3(i & 7, i >> 3 & 7, i >> 6) / side_;
  const int n = cutting::kBrickSide / side_;
  Block& block = blocks_[static_cast<size_t>((at.z * n + at.y) * n + at.x)];
  if (!block.known) {
    block.known = true;
    const double inner = 0.5 * (side_ - 1) * voxel_m_;
    const dvec3 middle = first_m_ + dvec3(at * side_) * voxel_m_ + inner;
    const double half_m = inner * std::sqrt(3.0);
    block.middle = r_.NearestTo(middle, limit_m_ + half_m, guess_);
    block.far = !block.middle || block.middle->nearest.distance_m - half_m > kFar_m;
  }
  const dvec3 p = PointOf(i);
  if (!block.far) {
    auto found = r_.NearestTo(p, limit_m_, guess_);
    if (!found) return {};
    // A mesh cuts the corner between wall and tooth, and is too far from what is left there.
    const int16_t phi = samples_[i];
    if (r_.at_rim_[found->triangle] && phi > 0 && phi < cutting::kPhiLimit) {
      found->nearest.distance_m =
          std::min(found->nearest.distance_m, phi * voxel_m_ / cutting::kPhiPerVoxel);
    }
    return found->nearest;
  }
  if (!block.middle) return {};
  const double distance_m = r_.query_->DistanceTo_m(block.middle->triangle, p);
  if (distance_m >= limit_m_) return {};
  Nearest out = block.middle->nearest;
  out.distance_m = distance_m;
  return out;
}

// Measures a region's area by a thin layer on the hollow's side of R's surface, in the cells in which faults are counted.
// Triangles round a sharp edge off by up to half a voxel, by another amount at every place of the grid.
void AcceptableCut::MeasureTask() {
  constexpr double kLayer_m = 0.1e-3;
  for (Region& region : surface_->regions) region.area_m2 = 0;
  const double voxel_m = initial_.spec().voxel_m();
  const ChangedBricks task(initial_, prepared_);
  for (int b = 0; b < initial_.spec().brick_count(); ++b) {
    if (!task.Brick(b)) continue;
    const BrickSamples before(initial_, b), wanted(prepared_, b);
    // Deeper, all of a voxel is beyond layer and leeway. Three voxels more than that: at the rim a voxel may be nearer than
    // its triangle.
    Brick brick(*this, b, std::max(kLayer_m, kLeeway_m) + 3 * voxel_m);
    for (int i = 0; i < cutting::kBrickVoxels; ++i) {
      const int32_t f0 = before.Solid(i), fr = std::min(f0, wanted.Solid(i));
      if (f0 == fr) continue;
      const auto nearest = brick.At(i);
      const double share = (f0 - fr) / 65536.0;
      const double share_m3 = share * voxel_m * voxel_m * voxel_m;
      if (!nearest) {
        task_beyond_m3_ += share_m3;
        continue;
      }
      const double side_m = fr > 0.5 * f0 ? -nearest->distance_m : nearest->distance_m;
      const Layer layer = Layer::In(side_m, voxel_m, share);
      task_beyond_m3_ += share_m3 * layer.Beyond();
      const double within = std::clamp((kLayer_m - layer.from_m) / layer.thickness_m(), 0.0, 1.0);
      for (const auto& [piece, paid] : nearest->Payers()) {
        surface_->regions[pieces()[piece].region].area_m2 += paid * share_m3 * within / kLayer_m;
      }
    }
  }
}

}  // namespace enamel::scoring
