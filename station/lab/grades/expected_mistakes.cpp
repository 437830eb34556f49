#include "station/lab/grades/expected_mistakes.h"

#include <algorithm>
#include <array>

namespace enamel::station::lab {
namespace {

using enum scoring::MistakeKind;

// In a place's name: the wall that the fault is named after.
constexpr std::string_view kWall = "@";

struct Row {
  std::vector<std::string_view> exercises;  // beginnings of their names; empty: any
  std::string_view fault;                   // beginning of its name
  int sign = 0;                             // of the fault's size; 0: any
  std::vector<ExpectedMistake> expected;
};

// The first row that fits.
const std::vector<Row>& Table() {
  static const std::vector<Row> table = {
      {{}, "none", 0, {}},
      {{}, "critical", 0, {}},
      {{"crown"}, "convergence", 0, {{kLeansOut, "axial"}}},
      {{"crown"}, "undercut", 0, {{kLeansIn, "axial"}}},
      // A stump that is 0.6 mm too slim all around besides.
      {{"crown"}, "lean", 0, {{kTipped, ""}, {kOverReduced, "axial"}}},
      {{"crown"}, "finish_line", 1, {{kDeep, "margin"}}},
      {{"crown"}, "finish_line", -1, {{kShallow, "margin"}}},
      {{"crown"}, "finish_waviness", 0, {{kWave, "margin"}}},
      {{"crown"}, "walls_over", 0, {{kOverReduced, "axial"}}},
      {{"crown"}, "walls_short", 0, {{kUnderReduced, "axial"}}},
      {{"crown"}, "top_over", 0, {{kOverReduced, "table"}, {kOverReduced, "cusp"}}},
      {{"crown"}, "top_short", 0, {{kUnderReduced, "table"}, {kUnderReduced, "cusp"}}},
      {{"crown"}, "gouge", 0, {{kPit, "table"}, {kPit, "cusp"}}},
      {{"crown"}, "left", 0, {{kBump, "table"}, {kBump, "cusp"}}},
      {{"crown"},
       "all_over",
       0,
       {{kOverReduced, "axial"},
        {kOverReduced, "table"},
        {kOverReduced, "cusp"},
        {kDeep, "margin"}}},
      {{"crown"},
       "all_short",
       0,
       {{kUnderReduced, "axial"},
        {kUnderReduced, "table"},
        {kUnderReduced, "cusp"},
        {kShallow, "margin"}}},
      {{"veneer"}, "floor_over", 0, {{kOverReduced, "face"}}},
      {{"veneer"}, "floor_short", 0, {{kUnderReduced, "face"}}},
      {{"veneer"}, "all_over", 0, {{kOverReduced, "face"}}},
      {{"veneer"}, "all_short", 0, {{kUnderReduced, "face"}}},
      {{"veneer"}, "tilt_floor", 0, {{kSlopes, "face"}, {kTipped, ""}}},
      {{"veneer"}, "floor_waviness", 0, {{kWave, "face"}}},
      {{"veneer"}, "gouge", 0, {{kPit, "face"}}},
      {{"veneer"}, "left", 0, {{kBump, "face"}}},
      {{"veneer"}, "margin", 0, {{kHole, ""}, {kOverReduced, "face"}}},

      // Walls that are short leave half of a slot that is hardly wider than the bur.
      {{"fissures"}, "walls_short", 0, {{kUnderExtended, "wall"}, {kNotDone, ""}}},
      // The block is a third of this floor.
      {{"trapezoid", "access-premolar"},
       "left",
       0,
       {{kLedge, "floor"}, {kBump, "floor"}, {kStanding, "*"}, {kShallow, "floor"}}},

      {{}, "floor_waviness", 0, {{kWave, "floor"}}},
      {{}, "waviness", 0, {{kWave, "wall"}}},
      {{}, "walls_over", 0, {{kOverExtended, "wall"}}},
      {{}, "walls_short", 0, {{kUnderExtended, "wall"}}},
      {{}, "wall_", 1, {{kOverExtended, "@"}}},
      {{}, "wall_", -1, {{kUnderExtended, "@"}}},
      {{}, "shift_", 0, {{kShifted, ""}}},
      {{}, "turn", 0, {{kTurned, ""}}},
      {{}, "tilt_floor", 0, {{kSlopes, "floor"}}},
      {{}, "tilt_", 1, {{kLeansOut, "@"}}},
      {{}, "tilt_", -1, {{kLeansIn, "@"}}},
      {{}, "taper", 0, {{kLeansOut, "wall"}}},
      {{}, "undercut", 0, {{kLeansIn, "wall"}}},
      {{}, "floor", 1, {{kDeep, "floor"}}},
      {{}, "floor", -1, {{kShallow, "floor"}}},
      {{}, "all_over", 0, {{kDeep, "floor"}, {kOverExtended, "wall"}}},
      {{}, "all_short", 0, {{kShallow, "floor"}, {kUnderExtended, "wall"}}},
      {{}, "gouge", 0, {{kPit, "floor"}}},
      {{}, "margin", 0, {{kOverExtended, "wall"}}},
      {{}, "pillar", 0, {{kStanding, "*"}}},
      // A block on the floor.
      {{}, "left", 0, {{kLedge, "floor"}, {kBump, "floor"}, {kStanding, "*"}}},
      {{}, "caries left", 0, {{kCaries, ""}, {kShallow, "floor"}}},
      {{}, "stopped early", 0, {{kNotDone, ""}, {kShallow, "floor"}}},
      {{}, "second hole", 0, {{kHole, ""}}},
      {{}, "shaved", 0, {{kHole, ""}, {kNeighbour, ""}}},
      {{}, "neighbour cut", 0, {{kNeighbour, ""}}},
  };
  return table;
}

// In a tooth with caries, whatever leaves tissue may be called by the caries in it.
bool MayLeaveCaries(const std::string& exercise, const Fault& fault) {
  if (!exercise.starts_with("caries") && !exercise.starts_with("class-2") &&
      !exercise.starts_with("mod")) {
    return false;
  }
  if (fault.name.starts_with("wall_") || fault.name == "floor") return fault.size < 0;
  return std::ranges::any_of(
      std::array{"tilt_", "taper", "undercut", "shift_", "turn", "waviness", "floor_waviness",
                 "all_short", "pillar", "left", "stopped early"},
      [&](const char* begins) { return fault.name.starts_with(begins); });
}

// The wall that a fault is named after, as a dentist calls it: the box of a class V looks towards the cheek.
std::string WallOf(const std::string& exercise, const Fault& fault) {
  const std::string side = fault.name.substr(fault.name.find('_') + 1);
  if (!exercise.starts_with("class-5") && !exercise.starts_with("trapezoid")) {
    return "wall_" + side;
  }
  return side == "buccal" ? "wall_gingival" : side == "lingual" ? "wall_occlusal" : "wall_" + side;
}

}  // namespace

bool ExpectedMistake::Is(const scoring::Mistake& mistake) const {
  if (mistake.kind != kind) return false;
  if (place == kAnyPlace) return true;
  return place.empty() ? mistake.place.empty() : mistake.place.starts_with(place);
}

std::vector<ExpectedMistake> ExpectedMistakesOf(const std::string& exercise, const Fault& fault) {
  if (!fault.critical.empty()) return {};
  for (const Row& row : Table()) {
    const bool of_exercise =
        row.exercises.empty() || std::ranges::any_of(row.exercises, [&](std::string_view name) {
          return exercise.starts_with(name);
        });
    const bool fits = of_exercise && fault.name.starts_with(row.fault) &&
                      (row.sign == 0 || row.sign * fault.size > 0);
    if (!fits) continue;
    std::vector<ExpectedMistake> out = row.expected;
    for (ExpectedMistake& each : out) {
      if (each.place == kWall) each.place = WallOf(exercise, fault);
    }
    if (MayLeaveCaries(exercise, fault)) out.push_back({kCaries, ""});
    return out;
  }
  return {};
}

}  // namespace enamel::station::lab
