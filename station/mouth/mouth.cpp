#include "station/mouth/mouth.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/scene/builtin/builtin.h"
#include "common/scene/tooth_number.h"
#include "station/mouth/antagonist.h"
#include "station/mouth/crowns.h"
#include "station/mouth/gingiva.h"
#include "station/mouth/rubber_dam.h"
#include "station/render/simplify.h"

namespace enamel::station::mouth {
namespace {

using cutting::Tissue;

// Where a cement line is sought: the origin is the middle of the crown, which is 12 mm high at most.
constexpr double kLowest_mm = -9, kHighest_mm = 1;
// What limits the gingiva does so this many directions to either side, a millimetre of a molar's
// neck. Farther aside it may rise by so much per mm: a papilla's side. Smoothed, because a fold in it
// would grow outward.
constexpr int kAside = 4;
constexpr double kSmooth_rad = 0.1;
constexpr double kNeckRadius_mm = 4.5, kRiseAside = 3;
constexpr double kNoLimit_mm = 1e3;
// Errors of the meshes: a pixel of a picture 1080 high that shows 16 mm, and five while it moves.
constexpr float kAtRest_mm = 0.02f, kMoving_mm = 0.08f;
// Points at which to test what covers the work.
constexpr size_t kWorkPoints = 48;

class Maker {
 public:
  Maker(const scene::Scene& scene, const cutting::Volume& volume)
      : scene_(scene), volume_(volume) {}

  render::Scenery Make(std::span<const surface::LineSegment> outline, const MouthOptions& options) {
    const TissueAt own = [this](const dvec3& p) { return At(p, false); };
    auto neck = NeckOf(own, {0, 0}, kLowest_mm, kHighest_mm);
    if (!neck) return {};
    const Around limit = LimitOf(outline);
    std::vector<Neck> necks{Lowered(own, *neck, limit)};
    if (HasNeighbours()) {
      AddNeighboursOfVolume(neck->margin_mm.Mean(), necks);
    } else {
      AddCrowns(own, necks);
    }
    HideBelow(necks[0]);
    auto pieces = options.isolation == scene::Isolation::kRubberDam
                      ? RubberDam(necks, limit)
                      : Gingiva(std::move(necks), limit).Pieces();
    for (render::GroupMesh& piece : pieces) {
      Reduce(piece);
      out_.fixed.push_back(InScene(std::move(piece)));
    }
    if (options.antagonist) AddAntagonist();
    // Without an outline the middle of the crown.
    if (outline.empty()) out_.work_mm.emplace_back(0);
    for (size_t i = 0; i < outline.size(); i += std::max<size_t>(outline.size() / kWorkPoints, 1)) {
      out_.work_mm.push_back(outline[i].from_m * 1e3f);
    }
    return std::move(out_);
  }

 private:
  // From the tooth's own frame, crown up, to the scene's, and back.
  dvec3 ToScene(const dvec3& p) const {
    return scene_.up == scene::Up::kBuccal ? scene::ToBuccalUp(p) : p;
  }
  dvec3 ToOwn(const dvec3& p) const {
    return scene_.up == scene::Up::kBuccal ? scene::FromBuccalUp(p) : p;
  }

  Tissue At(const dvec3& own_mm, bool neighbour) const {
    const dvec3 p = 1e-3 * ToScene(own_mm);
    if (volume_.DistanceAt_m(p) >= 0) return Tissue::kAir;
    const Tissue tissue = volume_.TissueAtPoint(p);
    return (tissue == Tissue::kNeighbour) == neighbour ? tissue : Tissue::kAir;
  }

  bool HasNeighbours() const {
    return std::ranges::any_of(
        scene_.tissues, [](const scene::TissueSpec& t) { return t.tissue == Tissue::kNeighbour; });
  }

  Around LimitOf(std::span<const surface::LineSegment> outline) const {
    Around lowest(kNoLimit_mm), out(kNoLimit_mm);
    for (const surface::LineSegment& line : outline) {
      for (const glm::vec3& end : {line.from_m, line.to_m}) {
        const dvec3 p = 1e3 * ToOwn(dvec3(end));
        double& here = lowest[Around::Nearest(std::atan2(p.y, p.x))];
        here = std::min(here, p.z);
      }
    }
    constexpr double kPerSample_mm =
        kRiseAside * kNeckRadius_mm * 2 * std::numbers::pi / Around::kCount;
    constexpr auto kCount = static_cast<int>(Around::kCount);
    for (int i = 0; i < kCount; ++i) {
      for (int k = -kCount / 2; k < kCount / 2; ++k) {
        const auto there = static_cast<size_t>((i + k + kCount) % kCount);
        double& here = out[static_cast<size_t>(i)];
        here = std::min(here, lowest[there] + kPerSample_mm * std::max(std::abs(k) - kAside, 0));
      }
    }
    return out.Smoothed(kSmooth_rad);
  }

  // The margin recedes from what is to be cut, smoothly.
  static Neck Lowered(const TissueAt& own, const Neck& neck, const Around& limit) {
    Around margin = neck.margin_mm;
    for (size_t i = 0; i < Around::kCount; ++i) {
      margin[i] = std::min(margin[i], limit[i] - kClearOfTarget_mm);
    }
    const Around smooth = margin.Smoothed(0.15);
    for (size_t i = 0; i < Around::kCount; ++i) margin[i] = std::min(margin[i], smooth[i]);
    return WithMargin(own, neck.middle_mm, margin);
  }

  // The scene's own neighbours are of one tissue, without a cement line: their margin is as high as
  // the tooth's.
  void AddNeighboursOfVolume(double margin_mm, std::vector<Neck>& necks) const {
    const TissueAt tissue = [this](const dvec3& p) { return At(p, true); };
    for (const double side : {1.0, -1.0}) {
      dvec3 sum(0);
      double count = 0;
      constexpr double kApart_mm = 0.5, kFar_mm = 20, kAcross_mm = 7;
      for (double x = 0; x < kFar_mm; x += kApart_mm) {
        for (double y = -kAcross_mm; y <= kAcross_mm; y += kApart_mm) {
          const dvec3 p(side * x, y, margin_mm);
          if (tissue(p) == Tissue::kAir) continue;
          sum += p;
          count += 1;
        }
      }
      if (count == 0) continue;
      necks.push_back(WithMargin(tissue, glm::dvec2(sum / count), Around(margin_mm)));
    }
  }

  void AddCrowns(const TissueAt& own, std::vector<Neck>& necks) {
    std::array<double, 2> half{};
    for (double z = -2; z <= 3; z += 0.25) {
      for (const bool negative : {false, true}) {
        double& here = half[negative];
        here = std::max(here, RadiusAt_mm(own, {0, 0}, negative ? std::numbers::pi : 0, z));
      }
    }
    for (const Crown& crown : NeighboursOf(scene_.tooth, half)) {
      necks.push_back(crown.neck());
      render::GroupMesh mesh = crown.Mesh();
      Reduce(mesh);
      out_.giving_way.push_back(InScene(std::move(mesh)));
    }
  }

  // A unit normal, so that the plane measures distances.
  void HideBelow(const Neck& own) {
    constexpr double kUnder_mm = 1;
    double lowest = kNoLimit_mm;
    for (size_t i = 0; i < Around::kCount; ++i) lowest = std::min(lowest, own.margin_mm[i]);
    out_.hides_below =
        glm::vec4(glm::vec3(ToScene({0, 0, 1})), static_cast<float>(kUnder_mm - lowest));
  }

  void AddAntagonist() {
    for (render::GroupMesh& mesh : AntagonistOf(scene_.tooth, Top_mm())) {
      Reduce(mesh);
      out_.opposite.push_back(InScene(std::move(mesh)));
    }
  }

  double Top_mm() const {
    constexpr double kApart_mm = 0.25, kHigh_mm = 8, kAside_mm = 5;
    for (double z = kHigh_mm; z > 0; z -= kApart_mm) {
      for (double x = -kAside_mm; x <= kAside_mm; x += kApart_mm) {
        for (double y = -kAside_mm; y <= kAside_mm; y += kApart_mm) {
          if (At({x, y, z}, false) != Tissue::kAir) return z;
        }
      }
    }
    return 0;
  }

  static void Reduce(render::GroupMesh& mesh) {
    // In this order (simplify.h).
    render::Coarsen(mesh, kMoving_mm);
    render::Simplify(mesh, kAtRest_mm);
  }

  render::GroupMesh InScene(render::GroupMesh mesh) const {
    for (render::GpuVertex& v : mesh.vertices) {
      const dvec3 p = ToScene(dvec3(v.position_mm[0], v.position_mm[1], v.position_mm[2]));
      const dvec3 n = ToScene(dvec3(v.normal[0], v.normal[1], v.normal[2]));
      for (int i = 0; i < 3; ++i) {
        v.position_mm[i] = static_cast<float>(p[i]);
        v.normal[i] = static_cast<int8_t>(std::lround(n[i]));
      }
    }
    mesh.bounds = render::BoundsOf(mesh.vertices, mesh.indices);
    return mesh;
  }

  const scene::Scene& scene_;
  const cutting::Volume& volume_;
  render::Scenery out_;
};

}  // namespace

render::Scenery MakeMouth(const scene::Scene& scene, const cutting::Volume& initial,
                          std::span<const surface::LineSegment> outline,
                          const MouthOptions& options) {
  if (!scene::IsToothNumber(scene.tooth)) return {};
  return Maker(scene, initial).Make(outline, options);
}

}  // namespace enamel::station::mouth
