#include "common/scoring/mistakes/explanation.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "common/scoring/mistakes/elastic_net.h"

namespace enamel::scoring {
namespace {

// Factors of lambda. The wall that moves alone costs less than half a shift with half a change of size; two opposite
// walls cost more than one shift.
constexpr double kWhole = 1, kRegion = 1.2, kOfRegion = 1.5, kLocal = 2.2;
// mm mm: of a deviation over an area A, what is noise is d sqrt(A). 0.02 mm over 4 mm^2.
constexpr double kLambda = 0.04;
constexpr double kMm = 1e3, kPatchStep_mm = 0.6, kLineStep_mm = 0.2;
constexpr double kStripWidths_mm[] = {0.6, 1.0};
constexpr double kPatchWidths_mm[] = {0.3, 0.6};
constexpr double kDegree = std::numbers::pi / 180;

struct Atom {
  Displacement motion;
  double weight = kWhole;  // of lambda
  double norm = 0;
  NetColumn at;  // by pieces, of unit norm
};

class Dictionary {
 public:
  Dictionary(const AcceptableCut& r) : r_(r), pieces_(r.pieces()) {
    Whole();
    for (const RegionKind kind :
         {RegionKind::kFloor, RegionKind::kTable, RegionKind::kMargin, RegionKind::kFace}) {
      OfKind(kind);
    }
    for (size_t i = 0; i < r.regions().size(); ++i) {
      if (r.regions()[i].kind != RegionKind::kLineAngle) OfRegion(i);
    }
    for (size_t i = 0; i < r.regions().size(); ++i) {
      if (r.regions()[i].kind == RegionKind::kLineAngle) continue;
      Parts(i);
      Patches(i);
    }
  }

  std::vector<Atom> Take() { return std::move(atoms_); }

 private:
  RegionKind KindOf(const SurfacePiece& piece) const { return r_.regions()[piece.region].kind; }

  static Displacement Of(MotionKind kind) {
    Displacement out;
    out.kind = kind;
    return out;
  }

  // `phi` of a piece, in mm to the unit of the motion's size.
  template <typename Phi, typename Counts>
  void Add(const Displacement& motion, double weight, const Counts& counts, const Phi& phi) {
    Atom atom{motion, weight, 0, {}};
    double square = 0;
    for (uint32_t i = 0; i < pieces_.size(); ++i) {
      const SurfacePiece& piece = pieces_[i];
      if (piece.at_edge || !counts(piece)) continue;
      const double value = phi(piece);
      if (std::fabs(value) < kLeast) continue;
      atom.at.emplace_back(i, value);
      square += piece.area_m2 * kMm * kMm * value * value;
    }
    atom.norm = std::sqrt(square);
    if (atom.norm < kMinNorm) return;
    for (auto& [i, value] : atom.at) value /= atom.norm;
    atoms_.push_back(std::move(atom));
  }

  template <typename Counts>
  dvec3 MiddleOf(const Counts& counts) const {
    dvec3 sum(0);
    double area = 0;
    for (const SurfacePiece& piece : pieces_) {
      if (piece.at_edge || !counts(piece)) continue;
      sum += piece.area_m2 * piece.at_m;
      area += piece.area_m2;
    }
    return area > 0 ? sum / area : sum;
  }

  void Whole() {
    auto all = [](const SurfacePiece&) { return true; };
    auto walls = [this](const SurfacePiece& p) { return IsWall(KindOf(p)); };
    const dvec3 middle = MiddleOf(all);
    // A surface that moves by v takes -n v of the solid.
    auto moved = [&](MotionKind kind, auto&& by) {
      Add(Of(kind), kWhole, all, [&](const SurfacePiece& p) { return -Dot(p.normal, by(p)); });
    };
    moved(MotionKind::kShiftX, [](const SurfacePiece&) { return dvec3(1, 0, 0); });
    moved(MotionKind::kShiftY, [](const SurfacePiece&) { return dvec3(0, 1, 0); });
    auto turned = [&](MotionKind kind, const dvec3& axis) {
      moved(kind, [&, axis](const SurfacePiece& p) {
        return glm::cross(axis, p.at_m - middle) * (kMm * kDegree);
      });
    };
    turned(MotionKind::kTurn, {0, 0, 1});
    turned(MotionKind::kTipX, {1, 0, 0});
    turned(MotionKind::kTipY, {0, 1, 0});
    Add(Of(MotionKind::kSize), kWhole, walls, [](const SurfacePiece&) { return 1.0; });
    // About each wall's own middle: how far out the walls are is kSize's to say.
    std::vector<double> middle_z_m(r_.regions().size());
    for (uint32_t i = 0; i < middle_z_m.size(); ++i) {
      middle_z_m[i] = MiddleOf([&](const SurfacePiece& p) { return p.region == i; }).z;
    }
    Add(Of(MotionKind::kTaper), kWhole, walls,
        [&](const SurfacePiece& p) { return (p.at_m.z - middle_z_m[p.region]) * kMm * kDegree; });
  }

  void OfKind(RegionKind kind) {
    size_t regions = 0;
    for (const Region& region : r_.regions()) regions += region.kind == kind;
    if (regions == 0) return;
    auto counts = [&](const SurfacePiece& p) { return KindOf(p) == kind; };
    const dvec3 middle = MiddleOf(counts);
    Displacement motion;
    motion.of = kind;
    motion.kind = MotionKind::kHeight;
    // With one region, its offset says the same.
    if (regions > 1) Add(motion, kRegion, counts, [](const SurfacePiece&) { return 1.0; });
    motion.kind = MotionKind::kSlopeX;
    Add(motion, kRegion, counts,
        [&](const SurfacePiece& p) { return (p.at_m.x - middle.x) * kMm * kDegree; });
    motion.kind = MotionKind::kSlopeY;
    Add(motion, kRegion, counts,
        [&](const SurfacePiece& p) { return (p.at_m.y - middle.y) * kMm * kDegree; });
  }

  void OfRegion(size_t region) {
    auto counts = [&](const SurfacePiece& p) { return p.region == region; };
    const dvec3 middle = MiddleOf(counts);
    Displacement motion;
    motion.region = static_cast<int>(region);
    motion.of = r_.regions()[region].kind;
    motion.kind = MotionKind::kOffset;
    Add(motion, kRegion, counts, [](const SurfacePiece&) { return 1.0; });
    if (!IsWall(motion.of)) return;
    motion.kind = MotionKind::kLean;
    Add(motion, kRegion, counts,
        [&](const SurfacePiece& p) { return (p.at_m.z - middle.z) * kMm * kDegree; });
  }

  // To either side of lines across it, and strips of walls.
  void Parts(size_t region) {
    const RegionKind kind = r_.regions()[region].kind;
    if (IsWall(kind)) {
      Lines(region, {0, 0, 1});
      const dvec3 n = MeanNormal(region);
      const dvec3 along(-n.y, n.x, 0);
      Lines(region, along);
      for (const double width : kStripWidths_mm) Strips(region, along, width);
    } else {
      Lines(region, {1, 0, 0});
      Lines(region, {0, 1, 0});
    }
  }
  dvec3 MeanNormal(size_t region) const {
    dvec3 sum(0);
    for (const SurfacePiece& p : pieces_) {
      if (p.region == region) sum += p.area_m2 * p.normal;
    }
    const double length = std::sqrt(sum.x * sum.x + sum.y * sum.y);
    return length > 0 ? sum / length : dvec3(1, 0, 0);
  }
  std::pair<double, double> Extent_mm(size_t region, const dvec3& along) const {
    double lo = 1e9, hi = -1e9;
    for (const SurfacePiece& p : pieces_) {
      if (p.region != region) continue;
      lo = std::min(lo, Dot(along, p.at_m) * kMm), hi = std::max(hi, Dot(along, p.at_m) * kMm);
    }
    return {lo, hi};
  }
  void AddPart(MotionKind kind, size_t region, const dvec3& along, double from_mm, double to_mm) {
    auto counts = [&](const SurfacePiece& p) {
      const double at = Dot(along, p.at_m) * kMm;
      return p.region == region && at >= from_mm && at < to_mm;
    };
    Displacement motion = Of(kind);
    motion.region = static_cast<int>(region);
    motion.of = r_.regions()[region].kind;
    motion.at_m = MiddleOf(counts);
    Add(motion, kOfRegion, counts, [](const SurfacePiece&) { return 1.0; });
  }
  void Lines(size_t region, const dvec3& along) {
    const auto [lo, hi] = Extent_mm(region, along);
    for (double line = lo + 2 * kLineStep_mm; line < hi - kLineStep_mm; line += kLineStep_mm) {
      AddPart(MotionKind::kPart, region, along, lo, line);
      AddPart(MotionKind::kPart, region, along, line, hi + 1);
    }
  }
  void Strips(size_t region, const dvec3& along, double width_mm) {
    const auto [lo, hi] = Extent_mm(region, along);
    for (double from = lo; from < hi - 0.5 * width_mm; from += kLineStep_mm) {
      AddPart(MotionKind::kStrip, region, along, from, from + width_mm);
    }
  }

  // At pieces about kPatchStep_mm apart, first come.
  void Patches(size_t region) {
    std::vector<dvec3> middles;
    for (const SurfacePiece& piece : pieces_) {
      if (piece.region != region || piece.at_edge) continue;
      const bool near = std::ranges::any_of(middles, [&](const dvec3& m) {
        const dvec3 way = (m - piece.at_m) * kMm;
        return Dot(way, way) < kPatchStep_mm * kPatchStep_mm;
      });
      if (!near) middles.push_back(piece.at_m);
    }
    for (const dvec3& middle : middles) {
      for (const double width : kPatchWidths_mm) {
        Displacement motion;
        motion.kind = MotionKind::kPatch;
        motion.region = static_cast<int>(region);
        motion.of = r_.regions()[region].kind;
        motion.at_m = middle;
        Add(
            motion, kLocal, [&](const SurfacePiece& p) { return p.region == region; },
            [&](const SurfacePiece& p) {
              // (1 - (r / 2.5 w)^2)^3: close to a Gaussian, without a transcendental function, and
              // with an end.
              const dvec3 way = (p.at_m - middle) * kMm;
              const double t = 1 - Dot(way, way) / (kReach * kReach * width * width);
              return t > 0 ? t * t * t : 0;
            });
      }
    }
  }

  static constexpr double kLeast = 1e-9, kMinNorm = 1e-6, kReach = 2.5;
  const AcceptableCut& r_;
  const std::vector<SurfacePiece>& pieces_;
  std::vector<Atom> atoms_;
};

// A motion of the whole is believed as far as all it moves moved that way: the weakest of its parts over the
// strongest, 0 to 1. Its parts are what it moves out and in, or where it moves all one way, the regions.
double Agreement(const AcceptableCut& r, const Atom& atom, const std::vector<double>& d) {
  double out = 0, in = 0;
  bool one_way = true;
  std::vector<double> by_region(r.regions().size()), weight(by_region.size());
  for (const auto& [i, phi] : atom.at) {
    const SurfacePiece& piece = r.pieces()[i];
    const double part = piece.area_m2 * phi * d[i];
    (phi > 0 ? out : in) += part;
    if ((phi > 0) != (atom.at.front().second > 0)) one_way = false;
    by_region[piece.region] += part;
    weight[piece.region] += piece.area_m2 * phi * phi;
  }
  double least = out, most = in;
  if (one_way || atom.motion.kind == MotionKind::kTaper) {
    least = most = 0;
    bool first = true;
    for (size_t k = 0; k < weight.size(); ++k) {
      if (!(weight[k] > 0)) continue;
      const double mean = by_region[k] / weight[k];
      if (first) least = most = mean;
      least = std::min(least, mean), most = std::max(most, mean);
      first = false;
    }
  }
  if (std::fabs(least) > std::fabs(most)) std::swap(least, most);
  return most == 0 ? 0 : std::clamp(least / most, 0.0, 1.0);
}

// Moves one region alone, or nearly: another motion says the same.
bool IsOfOneRegion(const AcceptableCut& r, const Atom& atom) {
  std::vector<double> weight(r.regions().size());
  double all = 0;
  for (const auto& [i, phi] : atom.at) {
    const double part = r.pieces()[i].area_m2 * phi * phi;
    weight[r.pieces()[i].region] += part;
    all += part;
  }
  constexpr double kNearlyAll = 0.8;
  return std::ranges::any_of(weight, [&](double w) { return w > kNearlyAll * all; });
}

// Dearer, without a step, the less its parts agree.
void WeighByAgreement(const AcceptableCut& r, const std::vector<double>& d,
                      std::vector<Atom>& atoms) {
  constexpr double kDoubted = 4;
  std::erase_if(atoms, [&](const Atom& atom) {
    return atom.motion.kind <= MotionKind::kTaper && IsOfOneRegion(r, atom);
  });
  for (Atom& atom : atoms) {
    if (atom.motion.kind > MotionKind::kSlopeY) continue;
    if (atom.motion.kind == MotionKind::kOffset || atom.motion.kind == MotionKind::kLean) continue;
    const double doubt = 1 - Agreement(r, atom, d);
    atom.weight *= 1 + kDoubted * doubt * doubt;
  }
}

}  // namespace

std::vector<Displacement> Explain(const AcceptableCut& r, const std::vector<double>& off_mm) {
  std::vector<Atom> atoms = Dictionary(r).Take();
  WeighByAgreement(r, off_mm, atoms);
  std::vector<double> areas_mm2, lambdas;
  std::vector<const NetColumn*> columns;
  for (const SurfacePiece& piece : r.pieces()) areas_mm2.push_back(piece.area_m2 * kMm * kMm);
  for (const Atom& atom : atoms) {
    columns.push_back(&atom.at);
    lambdas.push_back(kLambda * atom.weight);
  }
  const std::vector<double> beta = ElasticNet(columns, areas_mm2, off_mm, lambdas);
  std::vector<Displacement> out;
  for (size_t k = 0; k < atoms.size(); ++k) {
    if (beta[k] == 0) continue;
    Displacement motion = atoms[k].motion;
    motion.size = beta[k] / atoms[k].norm;
    motion.d_mm.assign(r.pieces().size(), 0);
    for (const auto& [i, phi] : atoms[k].at) motion.d_mm[i] = beta[k] * phi;
    out.push_back(std::move(motion));
  }
  return out;
}

}  // namespace enamel::scoring
