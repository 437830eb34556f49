#include "common/scene/builtin/drawn.h"

#include <algorithm>
#include <cmath>

#include "common/scene/builtin/builtin.h"
#include "common/scene/builtin/exercises.h"
#include "common/scene/json/kinds.h"
#include "common/scene/json/preparation.h"
#include "common/scene/json/read.h"
#include "common/scene/preparation.h"
#include "common/scene/tooth_number.h"

namespace enamel::scene {
namespace {

using glm::dvec2;

constexpr int32_t kMaxExtentUm = 100'000;

// An exercise of this kind on a scene, before its outline and words.
using Like = Exercise (*)(const Scene&, const Sha256&);
struct Kind {
  std::string_view name;
  Like make;
};
constexpr Kind kKinds[] = {{"class-1", ClassOneExercise},
                           {"class-2", ClassTwoExercise},
                           {"class-5", ClassFiveExercise},
                           {"access", AccessExercise}};

const Kind* KindNamed(std::string_view name) {
  const auto* it = std::ranges::find(kKinds, name, &Kind::name);
  return it == std::end(kKinds) ? nullptr : it;
}

struct RoundCorner {
  dvec2 at_um{0};
  double radius_um = 0;
};

double Length(const dvec2& v) { return std::sqrt(v.x * v.x + v.y * v.y); }

std::array<int32_t, 2> Whole(const dvec2& p_um) {
  return {static_cast<int32_t>(std::lround(p_um.x)), static_cast<int32_t>(std::lround(p_um.y))};
}

// The arc between two points at `radius` about `middle`, its ends left out: halved until a piece
// turns by at most 23 degrees, which leaves a chord 0.02 of the radius inside. Without trigonometry, so
// that every machine draws the same corners.
void AddArc(const dvec2& middle, const dvec2& from, const dvec2& to, double radius_um,
            std::vector<std::array<int32_t, 2>>& out) {
  constexpr double kCosine = 0.92;
  const dvec2 a = from - middle, b = to - middle;
  if (a.x * b.x + a.y * b.y >= kCosine * radius_um * radius_um) return;
  const dvec2 half = a + b;
  const dvec2 point = middle + half * (radius_um / Length(half));
  AddArc(middle, from, point, radius_um, out);
  out.push_back(Whole(point));
  AddArc(middle, point, to, radius_um, out);
}

// A polygon whose corners are arcs. False where no arc fits: its two sides lie on one line, or are shorter than the arc's
// tangents.
bool Rounded(const std::vector<RoundCorner>& corners, std::vector<std::array<int32_t, 2>>& out) {
  const size_t n = corners.size();
  std::vector<double> taken(n);  // of each side, from its first corner on
  for (size_t i = 0; i < n; ++i) {
    const size_t before = (i + n - 1) % n;
    const dvec2 at = corners[i].at_um;
    const dvec2 back = corners[before].at_um - at, on = corners[(i + 1) % n].at_um - at;
    const double radius = corners[i].radius_um;
    if (radius == 0) {
      out.push_back(Whole(at));
      continue;
    }
    const dvec2 u = back / Length(back), v = on / Length(on);
    // The tangents are radius * tan(turn / 2) long: with c the cosine between the sides,
    // sqrt((1 + c) / (1 - c)).
    const double c = u.x * v.x + u.y * v.y;
    constexpr double kOneLine = 1e-6;
    if (!(radius > 0 && std::fabs(c) < 1 - kOneLine)) return false;
    const double tangent = radius * std::sqrt((1 + c) / (1 - c));
    taken[before] += tangent, taken[i] += tangent;
    const dvec2 from = at + u * tangent, to = at + v * tangent;
    const dvec2 bisector = u + v;
    const dvec2 middle =
        at + bisector * (std::sqrt(tangent * tangent + radius * radius) / Length(bisector));
    out.push_back(Whole(from));
    AddArc(middle, from, to, radius, out);
    out.push_back(Whole(to));
  }
  for (size_t i = 0; i < n; ++i) {
    // Half a micrometre: two arcs may meet in the middle of a side.
    if (taken[i] > Length(corners[(i + 1) % n].at_um - corners[i].at_um) + 0.5) return false;
  }
  out.erase(std::unique(out.begin(), out.end()), out.end());
  if (out.size() > 1 && out.front() == out.back()) out.pop_back();
  return true;
}

PreparationPart ReadDrawnPart(ObjectReader& in) {
  PreparationPart part;
  part.outline = PreparationPart::Outline::kPolygon;
  std::vector<RoundCorner> corners;
  for (const auto& row : in.Rows("corners_um", 3, kMaxCorners)) {
    corners.push_back({{row[0], row[1]}, row[2]});
  }
  if (corners.size() < 3 || !Rounded(corners, part.corners_um) || !IsOutline(part.corners_um)) {
    in.Refuse(
        "corners_um",
        "at least 3 corners as [x, y, radius], counter-clockwise, whose arcs fit between them",
        "another outline");
  }
  part.depth_um = static_cast<int32_t>(in.Int("depth_um", 1, kMaxExtentUm));
  in.Finish();
  return part;
}

// From the tooth's own frame into the scene's, where +x is distal on the right of a lower jaw.
PreparationPart InScene(PreparationPart part, int tooth) {
  if (MesialX(tooth) > 0) return part;
  for (auto& corner : part.corners_um) corner[0] = -corner[0];
  // A mirror image runs the other way round.
  std::ranges::reverse(part.corners_um);
  return part;
}

const std::vector<DrawnExercise>& AllDrawn() {
  static const std::vector<DrawnExercise> all = [] {
    std::vector<DrawnExercise> out;
    for (const std::string_view text : DrawnDocuments()) {
      Result<DrawnExercise> drawn = DrawnFromJson(text);
      ENAMEL_CHECK(drawn.ok());
      out.push_back(std::move(*drawn));
    }
    return out;
  }();
  return all;
}

bool IsFor(const DrawnExercise& drawn, std::string_view scene) {
  if (scene.ends_with(kByLoadSuffix)) scene.remove_suffix(kByLoadSuffix.size());
  return std::ranges::find(drawn.scenes, scene) != drawn.scenes.end();
}

}  // namespace

Result<DrawnExercise> DrawnFromJson(std::string_view text) {
  ENAMEL_ASSIGN_OR_RETURN(const auto document, ParseBounded(text));
  Status status;
  ObjectReader in(document, "", status);
  DrawnExercise out;
  in.Format(kBuiltinExerciseKind);
  out.name = in.Name("name");
  out.like = in.Name("like");
  if (KindNamed(out.like) == nullptr) {
    std::string known;
    for (const Kind& kind : kKinds) known += (known.empty() ? "" : ", ") + std::string(kind.name);
    in.Refuse("like", "one of " + known, "\"" + out.like + "\"");
  }
  out.scenes = in.NameList("scenes", 8);
  out.landmark = in.Name("landmark");
  out.title = in.Text("title", 1, 200);
  out.instructions = in.Text("instructions", 1, 4'000);
  in.Text("source", 1, 1'000);
  for (ObjectReader& part : in.Objects("parts", 1, kMaxParts)) {
    out.parts.push_back(ReadDrawnPart(part));
  }
  in.Finish();
  ENAMEL_RETURN_IF_ERROR(status);
  return out;
}

std::vector<Exercise> DrawnExercises(const Scene& scene, const Sha256& scene_hash) {
  std::vector<Exercise> out;
  for (const DrawnExercise& drawn : AllDrawn()) {
    if (!IsFor(drawn, scene.name)) continue;
    Exercise e = KindNamed(drawn.like)->make(scene, scene_hash);
    e.name = NameFor(drawn.name.c_str(), scene);
    e.title = drawn.title;
    e.instructions = drawn.instructions;
    Preparation shape{drawn.landmark, drawn.title, drawn.parts};
    for (PreparationPart& part : shape.parts) part = InScene(std::move(part), scene.tooth);
    CavityTarget target = TargetFor(shape);
    target.leeway_side_um = e.target.leeway_side_um;
    target.leeway_bottom_um = e.target.leeway_bottom_um;
    target.container_um = e.target.container_um;
    e.target = std::move(target);
    out.push_back(std::move(e));
  }
  return out;
}

}  // namespace enamel::scene
