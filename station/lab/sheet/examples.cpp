#include "station/lab/sheet/examples.h"

#include <algorithm>
#include <cmath>

namespace enamel::station::lab {
namespace {

using Made = std::vector<Fault>;

constexpr double kDegree = 3.14159265358979323846 / 180;

Hollow Wanted(const Task& task) {
  return [task](const dvec3& p) { return task.Distance_m(p); };
}
// Where `kept` is negative nothing is taken.
CutPair Leaving(const Task& task, const Hollow& kept) {
  return {nullptr, Wanted(task),
          [task, kept](const dvec3& p) { return std::max(task.Distance_m(p), -kept(p)); }};
}
Hollow Block(const dvec3& lo_m, const dvec3& hi_m) {
  return [=](const dvec3& p) { return BoxDistance_m(p, lo_m, hi_m); };
}

// The whole cavity leans to distal, about the middle of its height.
CutPair Tipped(const GradedExercise& graded) {
  constexpr double kTip_deg = 10;
  const Task& task = graded.task();
  const dvec3 about = task.box.centre_m - dvec3(0, 0, 0.5 * task.box.depth_m);
  const double c = std::cos(kTip_deg * kDegree), s = std::sin(kTip_deg * kDegree);
  return {
      nullptr, Wanted(task), [=, box = task.box](const dvec3& p) {
        const dvec3 out = p - about;
        return box.Distance_m(about + dvec3(c * out.x + s * out.z, out.y, c * out.z - s * out.x));
      }};
}

// Down the middle of the distal wall, round, 0.35 mm deep.
CutPair Groove(const GradedExercise& graded) {
  constexpr double kRadius_m = 0.35e-3;
  const Task& task = graded.task();
  const BoxCavity& b = task.box;
  const double wall = b.centre_m.x - b.mesial_x * b.half_x_m, floor = b.centre_m.z - b.depth_m;
  return {nullptr, Wanted(task), [=](const dvec3& p) {
            const double x = p.x - wall, y = p.y - b.centre_m.y;
            const double rod = std::sqrt(x * x + y * y) - kRadius_m;
            return std::min(task.Distance_m(p), std::max(rod, floor - p.z));
          }};
}

// In the distal half of the floor, round, 0.5 mm deep.
CutPair Pit(const GradedExercise& graded) {
  constexpr double kRadius_m = 0.5e-3, kAside_m = 0.4e-3;
  const Task& task = graded.task();
  const BoxCavity& b = task.box;
  const dvec3 at = b.centre_m - dvec3(b.mesial_x * kAside_m, 0.3 * kAside_m, b.depth_m);
  return {nullptr, Wanted(task), [=](const dvec3& p) {
            const dvec3 out = p - at;
            return std::min(task.Distance_m(p), std::sqrt(Dot(out, out)) - kRadius_m);
          }};
}

constexpr double kTypical_m = 0.3e-3;
// Along all of the distal wall.
CutPair ShortOfWall(const GradedExercise& graded) {
  const BoxCavity& b = graded.task().box;
  const double wall = b.centre_m.x - b.mesial_x * b.half_x_m;
  const double inner = wall + b.mesial_x * kTypical_m;
  return Leaving(graded.task(),
                 Block({std::min(wall, inner), -1, -1}, {std::max(wall, inner), 1, 1}));
}
// Over all of the floor.
CutPair ShortOfFloor(const GradedExercise& graded) {
  const BoxCavity& b = graded.task().box;
  const double floor = b.centre_m.z - b.depth_m;
  return Leaving(graded.task(), Block({-1, -1, -1}, {1, 1, floor + kTypical_m}));
}

// At the foot of the distal wall's buccal half, 0.6 mm wide and 0.4 mm high.
CutPair Ledge(const GradedExercise& graded) {
  constexpr double kWide_m = 0.6e-3, kHigh_m = 0.4e-3;
  const BoxCavity& b = graded.task().box;
  const double wall = b.centre_m.x - b.mesial_x * b.half_x_m, floor = b.centre_m.z - b.depth_m;
  const double inner = wall + b.mesial_x * kWide_m;
  return Leaving(graded.task(), Block({std::min(wall, inner), b.centre_m.y, floor - 1},
                                      {std::max(wall, inner), b.centre_m.y + 1, floor + kHigh_m}));
}

// A lid over the distal wall, from the height of the fossa up.
CutPair Overhang(const GradedExercise& graded) {
  constexpr double kOver_m = 0.4e-3, kHigh_m = 0.5e-3;
  const BoxCavity& b = graded.task().box;
  const double wall = b.centre_m.x - b.mesial_x * b.half_x_m;
  const double inner = wall + b.mesial_x * kOver_m;
  return Leaving(graded.task(), Block({std::min(wall, inner) - (b.mesial_x > 0 ? 1 : 0), -1,
                                       b.centre_m.z - kHigh_m},
                                      {std::max(wall, inner) + (b.mesial_x > 0 ? 0 : 1), 1, 1}));
}

// A square column between the distal and the buccal wall, 0.8 mm along each.
CutPair Corner(const GradedExercise& graded) {
  constexpr double kSide_m = 0.8e-3;
  const BoxCavity& b = graded.task().box;
  return Leaving(graded.task(), [b](const dvec3& p) {
    const double x = -b.mesial_x * (p.x - b.centre_m.x) - b.half_x_m;
    const double y = p.y - b.centre_m.y - b.half_y_m;
    return -std::min(x, y) - kSide_m;
  });
}

// On the middle of the buccal margin, 0.8 mm wide and 0.4 mm high.
CutPair Lip(const GradedExercise& graded) {
  constexpr double kHalf_m = 0.4e-3, kHigh_m = 0.4e-3;
  const CrownCut& c = graded.task().crown;
  const CrownCut::Section& at = c.at_shoulder;
  return Leaving(graded.task(),
                 Block({at.middle_x_m - kHalf_m, at.middle_y_m + at.half_y_m, c.shoulder_z_m - 1},
                       {at.middle_x_m + kHalf_m, 1, c.shoulder_z_m + kHigh_m}));
}

// A fence of the tooth's own surface along the gingival floor, 0.4 mm thick and 1.2 mm high.
CutPair Fence(const GradedExercise& graded) {
  constexpr double kThick_m = 0.4e-3, kHigh_m = 1.2e-3;
  const cutting::Volume& tooth = graded.built().volume;
  const BoxCavity& b = graded.task().box;
  const double top = b.centre_m.z - b.depth_m + kHigh_m;
  dvec3 end(b.centre_m.x, b.centre_m.y, top);  // outwards to where the tooth ends
  for (const double h = tooth.spec().voxel_m();;) {
    const cutting::Tissue tissue = tooth.TissueAtPoint(end);
    if (tissue == cutting::Tissue::kAir || tissue == cutting::Tissue::kNeighbour) break;
    end.x += b.mesial_x * h;
  }
  const double inner = end.x - b.mesial_x * kThick_m;
  return Leaving(graded.task(), [=, way = b.mesial_x](const dvec3& p) {
    return std::max(way * (inner - p.x), p.z - top);
  });
}

// The floor this far over the highest pulp beneath it.
CutPair FloorOverPulp(const GradedExercise& graded, double cover_m) {
  constexpr size_t kFloor = 4;
  const cutting::Volume& tooth = graded.built().volume;
  BoxCavity box = graded.task().box;
  const double h = tooth.spec().voxel_m(), floor = box.centre_m.z - box.depth_m;
  double cover = 0;  // none found yet
  for (double x = -box.half_x_m; x <= box.half_x_m; x += h) {
    for (double y = -box.half_y_m; y <= box.half_y_m; y += h) {
      const double bottom = tooth.spec().origin_m().z;
      for (double z = floor; z > bottom && (cover == 0 || floor - z < cover); z -= h) {
        const dvec3 p(box.centre_m.x + x, box.centre_m.y + y, z);
        if (tooth.TissueAtPoint(p) == cutting::Tissue::kPulp) cover = floor - z;
      }
    }
  }
  box.faces[kFloor].moved_m = std::max(0.0, cover - cover_m);
  return {nullptr, Wanted(graded.task()), [box](const dvec3& p) { return box.Distance_m(p); }};
}

CutPair IntoPulp(const GradedExercise& graded) { return FloorOverPulp(graded, -0.9e-3); }

// The smallest that must cost a point.
const Fault* Typical(const Made& made, std::string_view name, double sign) {
  const Fault* out = nullptr;
  for (const Fault& f : made) {
    if (f.name != name || f.size * sign <= 0 || !f.must_cost) continue;
    if (out == nullptr || std::fabs(f.size) < std::fabs(out->size)) out = &f;
  }
  return out;
}

}  // namespace

std::span<const Example> Examples() {
  using enum scoring::MistakeKind;
  constexpr auto kAcross = Plane::kMesiodistal, kAlong = Plane::kBuccolingual;
  static const std::vector<Example> examples = {
      {kShifted, "molar", "class-1", "shift_buccal", 1, nullptr, kAlong},
      {kTurned, "molar", "class-1", "turn", 1, nullptr, Plane::kLevel},
      {kTipped, "molar", "class-1", "", 1, Tipped},
      {kOverExtended, "molar", "class-1", "wall_distal"},
      {kUnderExtended, "molar", "class-1", "", 1, ShortOfWall},
      {kLeansOut, "molar", "class-1", "taper"},
      {kLeansIn, "molar", "class-1", "undercut"},
      {kDeep, "molar", "class-1", "floor"},
      {kShallow, "molar", "class-1", "", 1, ShortOfFloor},
      {kOverReduced, "molar", "crown", "top_over"},
      {kUnderReduced, "molar", "crown", "top_short"},
      {kSlopes, "molar", "class-1", "tilt_floor"},
      {kGroove, "molar", "class-1", "", 1, Groove, Plane::kLevel},
      {kPit, "molar", "class-1", "", 1, Pit},
      {kLedge, "molar", "class-1", "", 1, Ledge, kAcross},
      {kOverhang, "molar", "class-1", "", 1, Overhang},
      {kLip, "molar", "crown", "", 1, Lip, kAlong},
      {kCorner, "molar", "class-1", "", 1, Corner, Plane::kLevel},
      {kBump, "molar", "crown", "left", 1, nullptr, kAcross},
      {kStanding, "molar", "class-1", "pillar"},
      {kWave, "molar", "class-1", "waviness", 1, nullptr, Plane::kLevel},
      {kHole, "molar", "crown", "second hole", 1, nullptr, kAlong},
      {kNeighbour, "molar-class-2", "class-2", "neighbour cut"},
      {kPulp, "molar", "class-1", "", 1, IntoPulp},
      {kCaries, "molar-caries", "caries", "caries left"},
      {kContact, "molar-class-2", "class-2", "", 1, Fence},
      {kNotDone, "molar", "class-1", "stopped early"},
  };
  return examples;
}

Result<MadeExample> Make(const Example& example, const GradedExercise& graded, const Made& made) {
  MadeExample out;
  if (example.own != nullptr) {
    out.cut = example.own(graded);
  } else if (const Fault* fault = Typical(made, example.made, example.sign)) {
    out.cut = {nullptr, Wanted(graded.task()), fault->taken, fault->neighbours};
  } else {
    return Status(Code::kInternal, "no fault '" + std::string(example.made) + "' is made in " +
                                       graded.exercise().name + ", for the example of " +
                                       std::string(NameOf(example.kind)));
  }
  out.cut.tooth = &graded.built().volume;
  ENAMEL_ASSIGN_OR_RETURN(const auto score, graded.Score(out.cut.taken, out.cut.neighbours));
  const auto named = std::ranges::find(score.mistakes, example.kind, &scoring::Mistake::kind);
  if (named == score.mistakes.end()) {
    std::string others;
    for (const scoring::Mistake& m : score.mistakes) {
      others += (others.empty() ? "" : ", ") + std::string(NameOf(m.kind)) + " " + m.place;
    }
    return Status(Code::kInternal,
                  "the example of " + std::string(NameOf(example.kind)) + " is called " + others);
  }
  out.mistake = *named;
  return out;
}

}  // namespace enamel::station::lab
