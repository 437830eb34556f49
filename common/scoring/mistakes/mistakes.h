#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "common/scoring/mistakes/explanation.h"
#include "common/scoring/mistakes/prices.h"

// What a teacher says of a cut: a few mistakes, each with its place, size and points. The motions of
// an explanation that belong together are one mistake (a wall's offset and lean, neighbouring
// patches of one sign), and the points that each region paid are shared among the mistakes that
// moved its surface, by how far each moved it where it cost. The shares sum to the cost, but for rounding.
//
// Deterministic. Thread safety: functions, any thread.
namespace enamel::scoring {

enum class MistakeKind : uint8_t {
  kShifted,       // the whole, mm
  kTurned,        // the whole, degrees
  kTipped,        // the whole, degrees
  kOverExtended,  // walls of a cavity, one or all, mm
  kUnderExtended,
  kLeansOut,  // degrees: opens to the top (a stump: converges more)
  kLeansIn,
  kDeep,  // floors and margins, mm
  kShallow,
  kOverReduced,  // tables, axial walls, faces, mm
  kUnderReduced,
  kSlopes,  // floors, tables, degrees
  kGroove,  // local, mm deep
  kPit,
  kLedge,      // left on a floor or low on a wall, mm high
  kOverhang,   // left at the rim
  kLip,        // left at a margin
  kCorner,     // left between two walls
  kBump,       // left elsewhere
  kStanding,   // left standing, away from where it should end: mm^3
  kWave,       // up and down, mm
  kHole,       // away from the task, mm^3
  kNeighbour,  // mm deep
  kPulp,       // mm^3
  kCaries,     // share left
  kContact,    // share of a third that was not opened
  kNotDone,    // share of the task left, beyond what the regions paid
  kUneven,     // what nothing of the above explains
};
inline constexpr size_t kMistakeKinds = 28;
std::string_view NameOf(MistakeKind kind);  // "shifted", "over_extended"
std::string_view UnitOf(MistakeKind kind);  // "mm", "deg", "mm3", "%"; of kUneven "mm"
// The side that a kind names: + cut too far, - left, 0 both.
int SignOf(MistakeKind kind);

// Under what an examiner writes a mistake down.
enum class Group : uint8_t { kOutline, kInternalForm, kMargins, kTissuePreserved, kHand };
inline constexpr size_t kGroups = 5;
std::string_view NameOf(
    Group group);  // "outline", "internal_form", "margins", "tissue_preserved", "hand"
// The group of a kind of region, or of a kind of damage.
Group GroupOf(std::string_view kind);

struct Mistake {
  MistakeKind kind = MistakeKind::kUneven;
  // "", of the whole; or a name of a region or of a third of a contact, or of all of one kind ("floor", "wall", "table").
  std::string place;
  double size = 0;   // in UnitOf(kind), above 0
  dvec3 at_m{0};     // the middle of where it cost
  dvec3 towards{0};  // kShifted: unit; kSlopes: where it is too deep
  double points = 0;
  Group group = Group::kOutline;

  bool operator==(const Mistake&) const = default;
};

struct FoundMistakes {
  std::vector<Mistake> mistakes;  // the dearest first; their points sum to `cost.sum`
  // Of each piece of R's surface: the mistake that moved it most, outwards of R's hollow and into it. -1: none.
  std::vector<int> over, left;
};
// `cost`: of MeasuresOf(r, faults).
FoundMistakes FindMistakes(const AcceptableCut& r, const FaultVolumes& faults, const CutCost& cost);

}  // namespace enamel::scoring
