#pragma once

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
  kNotDone,    // share of the task left, beyond what the regions paid
  kUneven,     // what nothing of the above explains
};
inline constexpr size_t kMistakeKinds = 27;
std::string_view NameOf(MistakeKind kind);  // "shifted", "over_extended"

struct Mistake {
  MistakeKind kind = MistakeKind::kUneven;
  // "", of the whole; or a region's name, or of all of one kind ("floor", "wall", "table").
  std::string place;
  double size = 0;   // in the kind's unit, above 0
  dvec3 at_m{0};     // the middle of where it cost
  dvec3 towards{0};  // kShifted: unit; kSlopes: where it is too deep
  double points = 0;
};

// The dearest mistake is first. Their points sum to `cost.sum`.
std::vector<Mistake> FindMistakes(const AcceptableCut& r, const FaultVolumes& faults,
                                  const CutCost& cost);

}  // namespace enamel::scoring
