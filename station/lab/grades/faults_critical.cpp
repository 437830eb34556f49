#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/scoring/mistakes/contact.h"
#include "station/lab/grades/fault_maker.h"

// The errors of schemas/critical_errors.json, as their made_by describes them, and which of them
// every other fault commits besides.
namespace enamel::station::lab {
namespace {

using cutting::Tissue;

constexpr double kIntoPulp_m = 0.3e-3, kFarWall_m = 1.5e-3, kGroove_mm = 0.5;
constexpr double kBeforeNeighbour_m = 0.3e-3, kOverhang_m = 0.2e-3, kMissing_deg = 60;
constexpr double kLeftOfLesion = 0.25;
// A tooth's crown ends so far below its highest point (CrownExercise's unknown tooth).
constexpr double kCrown_m = 6.5e-3;
constexpr double kNotUsed_percent = 100;

// Not taken where `kept` is negative.
Hollow Without(Hollow taken, Hollow kept) {
  return [taken = std::move(taken), kept = std::move(kept)](const dvec3& p) {
    return std::max(taken(p), -kept(p));
  };
}

}  // namespace

void FaultMaker::AddCritical(const char* error, Hollow taken, Neighbours neighbours) {
  auto part = [&](const Hollow& of) {
    return VolumeWhere_m3(
        volume_, grid_lo_m_, grid_hi_m_,
        [&](const dvec3& p, Tissue t) {
          return t != Tissue::kNeighbour && task_.Distance_m(p) < 0 && of(p) < 0;
        },
        Wanted());
  };
  if (task_m3_ == 0) task_m3_ = part(EverythingTaken);
  const double done_m3 = part(taken);
  // A cut through the task is known to half a voxel.
  constexpr double kTolerance_percent = 3;
  Add(std::string("critical: ") + error, {kNotUsed_percent * done_m3 / task_m3_}, "%",
      "task_done_percent", kTolerance_percent, std::move(taken), neighbours);
  out_.back().critical = error;
}

bool FaultMaker::Is(std::initializer_list<const char*> kinds) const {
  return std::ranges::any_of(kinds, [&](const char* k) { return exercise_.name.starts_with(k); });
}

void FaultMaker::AddCriticalPairs() {
  LookAtTissues();
  if (Is({"class-1", "class-2", "caries", "crown", "veneer", "class-5"})) AddPulpExposed();
  if (!pulp_m_.empty() && task_.kind != Task::Kind::kShape && !Is({"class-5"})) {
    const double neck = highest_m_ - kCrown_m;
    AddCritical("all_cut", [neck](const dvec3& p) { return neck - p.z; });
  }
  if (task_.kind == Task::Kind::kCrown) AddCriticalOfCrown();
  if (Is({"veneer"})) AddSideUntouched();
  if (task_.kind == Task::Kind::kBox && !pulp_m_.empty()) AddCriticalOfBox();
  for (Fault& fault : out_) {
    if (fault.critical.empty()) fault.critical = CommittedBy(fault);
  }
}

void FaultMaker::LookAtTissues() {
  const cutting::GridSpec& spec = volume_.spec();
  const dvec3 lo = grid_lo_m_, hi = grid_hi_m_;
  const double h = spec.voxel_m();
  highest_m_ = lo.z;
  for (double z = lo.z; z < hi.z; z += h) {
    for (double y = lo.y; y < hi.y; y += h) {
      for (double x = lo.x; x < hi.x; x += h) {
        const dvec3 p(x, y, z);
        if (volume_.DistanceAt_m(p) >= 0) continue;
        const Tissue tissue = volume_.TissueAtPoint(p);
        if (tissue != Tissue::kNeighbour) highest_m_ = std::max(highest_m_, z);
        if (tissue == Tissue::kPulp) pulp_m_.push_back(p);
        if (tissue == Tissue::kNeighbour || task_.Distance_m(p) >= 0) continue;
        // A share of the lesion is held against a limit: by the parts of its voxels.
        if (tissue == Tissue::kCaries) AddPartsOf(p, caries_m_);
        if (IsAtNeighbour(p)) contact_m_.push_back(p);
      }
    }
  }
}

// The middles of a voxel's 27 parts that are in the tooth and of the task.
void FaultMaker::AddPartsOf(const dvec3& voxel_m, std::vector<dvec3>& out) const {
  const double third = volume_.spec().voxel_m() / 3;
  for (int k = 0; k < 27; ++k) {
    const dvec3 p = voxel_m + (dvec3(k % 3, k / 3 % 3, k / 9) - 1.0) * third;
    if (volume_.DistanceAt_m(p) < 0 && task_.Distance_m(p) < 0) out.push_back(p);
  }
}

// The tooth's last voxel before a neighbour that it touches, but for a gap.
bool FaultMaker::IsAtNeighbour(const dvec3& p) const {
  const double h = volume_.spec().voxel_m();
  for (double away = h; away <= scoring::kContactGap_m + h; away += 0.5 * h) {
    const dvec3 next = p + dvec3(task_.box.mesial_x * away, 0, 0);
    if (volume_.DistanceAt_m(next) >= 0) continue;
    return volume_.TissueAtPoint(next) == Tissue::kNeighbour;
  }
  return false;
}

bool FaultMaker::Fails(std::string_view error) const {
  const auto& all = exercise_.rubric.critical;
  return std::ranges::find(all, error, &scene::RubricCritical::error) != all.end();
}

double FaultMaker::LimitOf(std::string_view error) const {
  const auto& all = exercise_.rubric.critical;
  const auto found = std::ranges::find(all, error, &scene::RubricCritical::error);
  return found == all.end() ? 100 : found->limit;
}

// The task grown towards the pulp where that is nearest, within a millimetre.
void FaultMaker::AddPulpExposed() {
  if (pulp_m_.empty()) return;
  const auto nearest =
      std::ranges::min_element(pulp_m_, {}, [&](const dvec3& p) { return task_.Distance_m(p); });
  constexpr double kAbout_m = 1e-3;
  const double by = std::max(0.0, task_.Distance_m(*nearest)) + kIntoPulp_m;
  AddCritical("pulp_exposed", [=, at = *nearest, wanted = Wanted()](const dvec3& p) {
    const dvec3 d = p - at;
    return std::min(wanted(p), std::max(wanted(p) - by, std::sqrt(Dot(d, d)) - kAbout_m));
  });
}

void FaultMaker::AddCriticalOfBox() {
  const BoxCavity& b = task_.box;
  if (Is({"class-1", "class-2", "class-5"})) {
    // Onto the next cusp or surface; a class II's from the ridge into the tooth.
    const dvec3 by = task_.open_mesial ? dvec3(-b.mesial_x * (2 * b.half_x_m + 0.6e-3), 0, 0)
                                       : dvec3(0, 2 * b.half_y_m + 0.6e-3, 0);
    AddCritical("wrong_place", [=, wanted = Wanted()](const dvec3& p) { return wanted(p - by); });
  }
  if (Is({"class-1", "class-2"})) {
    constexpr size_t kBuccalWall = 2;
    AddCritical("gross_overextension", BoxWith(kBuccalWall, {.moved_m = kFarWall_m}));
  }
  if (Is({"class-2"})) {
    if (const auto next = NearestNeighbour()) {
      const double end = b.mesial_x * next->x - kBeforeNeighbour_m;
      AddCritical("contact_left", [=, wanted = Wanted(), way = b.mesial_x](const dvec3& p) {
        return std::max(wanted(p), way * p.x - end);
      });
    }
  }
  if (Is({"caries", "class-2"}) && !caries_m_.empty()) {
    std::vector<double> heights;
    for (const dvec3& p : caries_m_) heights.push_back(p.z);
    std::ranges::sort(heights);
    const double z = heights[static_cast<size_t>(kLeftOfLesion * double(heights.size()))];
    AddCritical("caries_left_deep",
                [=, wanted = Wanted()](const dvec3& p) { return std::max(wanted(p), z - p.z); });
  }
}

void FaultMaker::AddCriticalOfCrown() {
  const CrownCut& c = task_.crown;
  constexpr double kNoTop_m = 5e-3;
  AddCritical("occlusal_untouched", Cut(c.Moved(0, -kNoTop_m)));
  AddSideUntouched();
  const CrownCut::Section& s = c.at_shoulder;
  // A wedge of 60 degrees towards mesial, up to a millimetre above the shoulder.
  const double half = 0.5 * kMissing_deg * std::numbers::pi / 180;
  AddCritical("finish_line_missing", Without(Wanted(), [=, way = task_.box.mesial_x,
                                                        z = c.shoulder_z_m + 1e-3](const dvec3& p) {
                const double x = way * (p.x - s.middle_x_m), y = std::fabs(p.y - s.middle_y_m);
                return std::max(y * std::cos(half) - x * std::sin(half), p.z - z);
              }));
  const double height = c.top_z_m - c.shoulder_z_m;
  AddCritical("cannot_seat",
              Cut(c.Undercut(-2 * std::atan(kOverhang_m / height) * 180 / std::numbers::pi)));
  if (const auto next = NearestNeighbour()) AddNick(*next, {kGroove_mm, true});
}

// All but the side towards +x, as far as its diagonals; a crown's top is reduced there too.
void FaultMaker::AddSideUntouched() {
  const scene::CavityTarget& t = exercise_.target;
  const double aside = double(t.half_size_um[0]) / double(t.half_size_um[1]);
  AddCritical("one_axial_wall_untouched",
              Without(Wanted(), [=, task = task_, at = landmark_m_](const dvec3& p) {
                const double side = aside * std::fabs(p.y - at.y) - (p.x - at.x);
                const double of_side = side / std::sqrt(1 + aside * aside);
                if (task.kind != Task::Kind::kCrown) return of_side;
                return std::max(of_side, task.crown.OverTop_m(p));
              }));
}

// What a fault commits by its own geometry, whatever the score finds.
std::string FaultMaker::CommittedBy(const Fault& fault) const {
  if (fault.name == "nothing") return "nothing_cut";
  if (fault.name == "everything removed") return "all_cut";
  if (fault.name == "neighbour cut" && fault.nick_mm >= 0.3 && Fails("neighbour_damaged")) {
    return "neighbour_damaged";
  }
  const double h = volume_.spec().voxel_m();
  if (Fails("pulp_exposed") &&
      std::ranges::any_of(pulp_m_, [&](const dvec3& p) { return fault.taken(p) < -h; })) {
    return "pulp_exposed";
  }
  auto left_percent = [&](const std::vector<dvec3>& of) {
    const auto left =
        std::ranges::count_if(of, [&](const dvec3& p) { return fault.taken(p) >= 0; });
    return of.empty() ? 0 : 100 * double(left) / double(of.size());
  };
  if (left_percent(contact_m_) > LimitOf("contact_left")) {
    return "contact_left";
  }
  if (left_percent(caries_m_) > LimitOf("caries_left_deep")) {
    return "caries_left_deep";
  }
  // The lower half of all walls is untouched.
  if (fault.name == "stopped early" && Is({"crown"})) return "finish_line_missing";
  if (fault.name == "stopped early" && Is({"veneer"})) return "one_axial_wall_untouched";
  if (fault.name == "undercut" && Is({"crown"})) {
    const double height_mm = kMm * (task_.crown.top_z_m - task_.crown.shoulder_z_m);
    const double overhang_mm = 2 * std::tan(-fault.size / 2 * std::numbers::pi / 180) * height_mm;
    if (overhang_mm > LimitOf("cannot_seat")) return "cannot_seat";
  }
  return {};
}

}  // namespace enamel::station::lab
