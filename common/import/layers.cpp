#include "common/import/layers.h"

#include <algorithm>
#include <cmath>

#include "common/mesh/facet.h"
#include "common/mesh/units.h"

namespace enamel::import {
namespace {

using cutting::Tissue;

constexpr size_t kEnamel = 0, kDentin = 1, kPulp = 2;
constexpr double kLargestCapShare = 0.47;  // the caps of a dome lie within the dentin
// A pulp may be some times smaller than the dentin. This catches units a thousand apart; a
// centimetre for a millimetre it does not.
constexpr double kMaxTimesLarger = 30;
constexpr int kNestingSamples = 16;  // along an axis
// Tests hold the lengths and cosines from here on, and those of the boundary (layer_boundary.cpp):
// shells with known gaps and crossings (layers_test.cpp), and a scanned crown with 0.02 mm of noise,
// which folds its surfaces (RealCrownTest.NoisySurfaces...).
constexpr double kLook_mm = 0.5;      // how far apart surfaces are still measured
constexpr double kFaceToFace = -0.5;  // cosine of their normals
constexpr double kAcrossCap = -0.5;   // between the ways to a cap and to the dentin across it
constexpr double kTouching_mm = 1e-4;
constexpr double kMaxBeyond = 0.02;
constexpr double kMinMeeting = 0.1;  // of the smaller surface
constexpr double kMinShared = 0.1;   // of the smaller volume
constexpr double kBehind_mm = 1.0;

std::string Name(size_t layer) { return std::string(cutting::TissueName(kLayerTissues[layer])); }

Status Invalid(const std::string& what, const char* field = "") {
  return Status(Code::kInvalidInput, what, field);
}

dvec3 Unit(const dvec3& v) {
  const double size = std::sqrt(Dot(v, v));
  return size > 0 ? v / size : dvec3(0);
}

// At an angle of more than this cosine; also where one of them is hardly a way at all.
bool AreOpposite(const dvec3& l, const dvec3& r, double cosine) {
  const double product = std::sqrt(Dot(l, l) * Dot(r, r));
  return product < kTouching_mm * kTouching_mm || Dot(l, r) < cosine * product;
}

// Whether a step from p, away from a surface that is `way` behind it, enters the solid before
// `bridge` from that surface.
bool Enters(const LayeredTooth::Surface& solid, const dvec3& p, const dvec3& way, double bridge) {
  const double size = std::sqrt(Dot(way, way));
  if (size < kTouching_mm) return true;
  // Twice, since a thin shell may lie wholly before the end.
  for (double part : {0.5, 1.0}) {
    if (solid.whole.Inside(p + way * (part * (bridge - size) / size))) return true;
  }
  return false;
}

Status CheckTogether(size_t layer, const mesh::Triangles& surface, const mesh::Triangles& dentin) {
  const mesh::Box own = mesh::BoxOf(surface), other = mesh::BoxOf(dentin);
  const double ratio = own.extent() / std::max(other.extent(), 1e-12);
  bool apart = false;
  for (int k = 0; k < 3; ++k) apart |= own.lo[k] > other.hi[k] || own.hi[k] < other.lo[k];
  if (ratio < kMaxTimesLarger && ratio > 1 / kMaxTimesLarger && !apart) return Status::Ok();
  return Invalid(Name(layer) + ": expected it around or within the dentin (" +
                 mesh::Fixed(other.extent(), 3) + " mm), found a surface of " +
                 mesh::Fixed(own.extent(), 3) + " mm" + (apart ? " apart from it" : "") +
                 ": all surfaces must be of one tooth, in one unit and one frame");
}

Status InLayer(size_t layer, const Status& status) {
  return Status(status.code(), Name(layer) + ": " + status.message(), status.field());
}

dvec3 MiddleOfSurface(const mesh::Triangles& mesh) {
  dvec3 sum(0);
  double area = 0;
  for (const auto& t : mesh.indices) {
    const mesh::Facet f = mesh::Facet::Of(mesh, t);
    const dvec3 n = f.AreaNormal();
    const double size = std::sqrt(Dot(n, n));
    sum += size * f.Middle();
    area += size;
  }
  return area > 0 ? sum / area : sum;
}

void TakeHollowAsPulp(LayerSolids& layers, const LayerOptions& options) {
  const mesh::Solid& dentin = *layers.solids[kDentin];
  if (layers.solids[kPulp] || dentin.hollows.indices.empty()) return;
  mesh::RepairOptions repair;
  repair.finest_mm = options.finest_mm;
  // Its own way through the repair, since pulp may overlap itself like any other surface.
  Result<mesh::Solid> pulp = mesh::MakeSolid(dentin.hollows, repair);
  if (!pulp.ok()) return;
  layers.report.push_back("no pulp given: the hollow in the dentin (" +
                          mesh::Fixed(mesh::SignedVolume(pulp->mesh)) +
                          " mm3) is taken as the pulp");
  layers.solids[kPulp] = std::move(*pulp);
}

}  // namespace

Result<LayerSolids> RepairLayers(
    const std::array<std::optional<mesh::Triangles>, kLayers>& surfaces_mm,
    const LayerOptions& options) {
  if (!surfaces_mm[kDentin]) {
    return Invalid(
        "dentin: expected a surface of it beside that of enamel or pulp, found none; a crown's "
        "outside alone is imported as one file, without naming a tissue");
  }
  LayerSolids out;
  for (size_t layer = 0; layer < kLayers; ++layer) {
    if (!surfaces_mm[layer]) continue;
    if (surfaces_mm[layer]->indices.empty())
      return Invalid(Name(layer) + ": its surface holds no triangles");
    ENAMEL_RETURN_IF_ERROR(CheckTogether(layer, *surfaces_mm[layer], *surfaces_mm[kDentin]));
    mesh::RepairOptions repair;
    // An enamel shell's inside is a hollow that must stay one; the dentin's is the pulp.
    repair.keep_hollows = layer == kEnamel;
    repair.largest_cap_share = kLargestCapShare;
    repair.finest_mm = options.finest_mm;
    Result<mesh::Solid> solid = mesh::MakeSolid(*surfaces_mm[layer], repair);
    if (!solid.ok()) return InLayer(layer, solid.status());
    for (const std::string& line : Describe(solid->report))
      out.report.push_back(Name(layer) + ": " + line);
    out.solids[layer] = std::move(*solid);
  }
  TakeHollowAsPulp(out, options);
  if (!out.solids[kEnamel] && !out.solids[kPulp])
    return Invalid("dentin: expected a surface of enamel or pulp beside it, found none");
  if (!out.solids[kPulp]) out.report.push_back("no pulp given: dentin throughout");
  if (!out.solids[kEnamel]) out.report.push_back("no enamel given: the dentin is bare");
  return out;
}

dvec3 RiseOf(const LayerSolids& layers) {
  if (!layers.solids[kEnamel] || !layers.solids[kDentin]) return dvec3(0);
  return MiddleOfSurface(mesh::Select(*layers.solids[kEnamel], false)) -
         MiddleOfSurface(mesh::Select(*layers.solids[kDentin], false));
}

// The side of a cleft that is nearer; nothing when p is in none.
std::optional<size_t> LayeredTooth::NearerOfCleft(const dvec3& p, const Distances& d) const {
  for (size_t i = 0; i < kLayers; ++i)
    for (size_t k = i + 1; k < kLayers; ++k) {
      if (!surfaces_[i] || !surfaces_[k] || d.to[i] < 0 || d.to[k] < 0) continue;
      if (d.to[i] + d.to[k] > bridge_) continue;
      const mesh::TriangleTree &one = surfaces_[i]->boundary, &other = surfaces_[k]->boundary;
      uint32_t on_one = 0, on_other = 0;
      // Both are known to lie within the bridge; twice that only makes sure that the triangle is
      // found.
      one.Distance(p, 2 * bridge_, &on_one);
      other.Distance(p, 2 * bridge_, &on_other);
      const dvec3 way = one.NearestOn(on_one, p) - p, other_way = other.NearestOn(on_other, p) - p;
      if (AreOpposite(way, other_way, kOpposite) || Enters(*surfaces_[k], p, -way, bridge_) ||
          Enters(*surfaces_[i], p, -other_way, bridge_))
        return d.to[i] < d.to[k] ? i : k;
    }
  return std::nullopt;
}

bool LayeredTooth::IsBehindCap(const dvec3& p) const {
  const mesh::TriangleTree &caps = surfaces_[kEnamel]->caps, &dentin = surfaces_[kDentin]->boundary;
  uint32_t cap = 0, other = 0;
  if (caps.empty() || caps.Distance(p, kBehind_mm, &cap) >= kBehind_mm) return false;
  if (dentin.Distance(p, kBehind_mm, &other) >= kBehind_mm) return false;
  return AreOpposite(caps.NearestOn(cap, p) - p, dentin.NearestOn(other, p) - p, kAcrossCap);
}

bool LayeredTooth::Inside(const dvec3& p, const Distances& d) const {
  return std::any_of(d.to.begin(), d.to.end(), [](double s) { return s < 0; }) ||
         NearerOfCleft(p, d).has_value();
}

Tissue LayeredTooth::TissueAt(const dvec3& p, const Distances& d) const {
  const double enamel = d.to[kEnamel], dentin = d.to[kDentin], pulp = d.to[kPulp];
  // From the inside out: where tissues are nested the innermost wins, side by side the deeper.
  if (pulp < 0) return dentin < pulp && !nested_[kDentin][kPulp] ? Tissue::kDentin : Tissue::kPulp;
  if (dentin < 0)
    return enamel < dentin && !nested_[kEnamel][kDentin] ? Tissue::kEnamel : Tissue::kDentin;
  if (enamel < 0) {
    if (const auto side = NearerOfCleft(p, d)) return kLayerTissues[*side];
    return IsBehindCap(p) ? Tissue::kDentin : Tissue::kEnamel;
  }
  const auto nearest =
      static_cast<size_t>(std::min_element(d.to.begin(), d.to.end()) - d.to.begin());
  return d.to[nearest] < d.reach ? kLayerTissues[nearest] : Tissue::kAir;
}

Result<LayeredTooth> LayeredTooth::Make(LayerSolids layers, const LayerOptions& options) {
  LayeredTooth tooth;
  tooth.bridge_ = options.bridge_mm;
  tooth.report_ = std::move(layers.report);
  for (size_t i = 0; i < kLayers; ++i) {
    if (!layers.solids[i]) continue;
    mesh::Solid& solid = *layers.solids[i];
    mesh::TriangleTree boundary(solid.boundary), whole(solid.mesh), own(mesh::Select(solid, false)),
        caps(mesh::Select(solid, true));
    tooth.surfaces_[i] = std::make_unique<Surface>(Surface{
        std::move(solid), std::move(boundary), std::move(whole), std::move(own), std::move(caps)});
  }
  for (auto [outer, inner] :
       {std::pair{Layer::kEnamel, Layer::kDentin}, std::pair{Layer::kDentin, Layer::kPulp}})
    ENAMEL_RETURN_IF_ERROR(tooth.FindRelation(outer, inner));
  tooth.ReportPulpOutside();
  tooth.FindBoundary(options.finest_mm);
  return tooth;
}

// The share of the smaller solid that is in both; by samples spread evenly over the inner one's
// bounding box.
double LayeredTooth::SharedVolume(size_t outer, size_t inner) const {
  const Surface &l = *surfaces_[outer], &r = *surfaces_[inner];
  const mesh::Box box = mesh::BoxOf(r.solid.mesh);
  int both = 0, n = kNestingSamples;
  for (int i = 0; i < n * n * n; ++i) {
    const dvec3 cell(i % n, i / n % n, i / (n * n));
    const dvec3 p = box.lo + box.size() * (cell + 0.5) / static_cast<double>(n);
    // 4096 samples: enough to distinguish a share of a tenth from none.
    both += r.whole.Inside(p) && l.whole.Inside(p);
  }
  const dvec3 size = box.size() / static_cast<double>(n);
  return both * size.x * size.y * size.z /
         std::min(mesh::SignedVolume(l.solid.mesh), mesh::SignedVolume(r.solid.mesh));
}

LayeredTooth::Meeting LayeredTooth::Measure(size_t outer, size_t inner) const {
  const mesh::Solid& solid = surfaces_[outer]->solid;
  const mesh::TriangleTree& other = surfaces_[inner]->boundary;
  Meeting m;
  mesh::SignedProbe probe(other, surfaces_[inner]->whole);
  for (const auto& t : solid.mesh.indices) {
    if (mesh::IsCap(solid, t)) continue;
    const mesh::Facet f = mesh::Facet::Of(solid.mesh, t);
    const dvec3 normal = f.AreaNormal();
    const double area = std::sqrt(Dot(normal, normal)),
                 apart = probe.Distance(f.Middle(), kLook_mm);
    m.own_mm2 += area;
    // Only what faces the other surface is an interface: a dome's outside lies near nothing.
    if (std::abs(apart) >= kLook_mm) continue;
    const mesh::TriangleTree::Triangle& facing = other.At(probe.nearest());
    const dvec3 its = Unit(glm::cross(facing.b - facing.a, facing.c - facing.a));
    if (Dot(Unit(normal), its) > kFaceToFace) continue;
    m.area_mm2 += area;
    if (std::abs(apart) > bridge_) m.beyond_mm2 += area;
    m.gap_mm = std::max(m.gap_mm, apart);
    m.crossing_mm = std::max(m.crossing_mm, -apart);
  }
  return m;
}

// Side by side when they face each other; nested when one shares volume with the other.
Status LayeredTooth::FindRelation(Layer outer_layer, Layer inner_layer) {
  const auto outer = static_cast<size_t>(outer_layer), inner = static_cast<size_t>(inner_layer);
  if (!surfaces_[outer] || !surfaces_[inner]) return Status::Ok();
  const Meeting m = Measure(outer, inner);
  const std::string names = Name(outer) + " and " + Name(inner);
  const double smaller = std::min(m.own_mm2, mesh::SurfaceArea(surfaces_[inner]->solid.mesh));
  if (m.area_mm2 < kMinMeeting * smaller) {
    nested_[outer][inner] = true;
    if (SharedVolume(outer, inner) > kMinShared) return Status::Ok();
    return Invalid(names + " do not meet: their surfaces face each other within " +
                   mesh::Fixed(kLook_mm, 1) + " mm over " + mesh::Fixed(m.area_mm2) +
                   " mm2 only, and neither is within the other; give surfaces of one tooth, in one "
                   "unit and one frame");
  }
  const std::string figures = "gaps of up to " + mesh::Fixed(m.gap_mm, 3) +
                              " mm and crossings of up to " + mesh::Fixed(m.crossing_mm, 3) +
                              " mm over " + mesh::Fixed(m.area_mm2, 1) + " mm2";
  if (m.beyond_mm2 > kMaxBeyond * m.area_mm2) {
    return Invalid(names + ": expected surfaces that meet to " + mesh::Fixed(bridge_, 2) +
                       " mm, found " + figures + ", " +
                       mesh::Fixed(100 * m.beyond_mm2 / m.area_mm2, 0) +
                       " % of it beyond: mend them in a mesh program, or bridge wider gaps",
                   "bridge_um");
  }
  report_.push_back(
      names + " meet with " + figures + "; up to " + mesh::Fixed(bridge_, 2) + " mm is bridged" +
      (m.beyond_mm2 > 0 ? ", " + mesh::Fixed(m.beyond_mm2) + " mm2 lie beyond that" : ""));
  return Status::Ok();
}

void LayeredTooth::ReportPulpOutside() {
  if (!surfaces_[kPulp] || !nested_[kDentin][kPulp]) return;
  const mesh::Solid& pulp = surfaces_[kPulp]->solid;
  mesh::SignedProbe dentin(surfaces_[kDentin]->boundary, surfaces_[kDentin]->whole);
  double deepest = 0, outside = 0, area = 0;
  for (const auto& t : pulp.mesh.indices) {
    const mesh::Facet f = mesh::Facet::Of(pulp.mesh, t);
    const dvec3 normal = f.AreaNormal();
    const double size = std::sqrt(Dot(normal, normal)), s = dentin.Distance(f.Middle(), 5);
    area += size;
    if (s <= 0) continue;
    outside += size;
    deepest = std::max(deepest, s);
  }
  if (outside > 0) {
    report_.push_back("pulp reaches out of the dentin by up to " + mesh::Fixed(deepest, 3) +
                      " mm, over " + mesh::Fixed(100 * outside / area, 1) + " % of its surface");
  }
}

}  // namespace enamel::import
