#include "common/scene/json/preparation.h"

#include <algorithm>
#include <boost/json.hpp>
#include <cmath>

namespace enamel::scene {
namespace {

namespace json = boost::json;
using Outline = PreparationPart::Outline;
using Corner = std::array<int32_t, 2>;

constexpr int32_t kMaxExtentUm = 100'000;
constexpr int32_t kMaxReliefSide = 65;
constexpr const char* kNames[] = {"box", "disc", "polygon", "stump"};

json::array PairJson(const std::array<int32_t, 2>& pair) { return {pair[0], pair[1]}; }

std::array<int32_t, 2> ReadPair(ObjectReader& in, const char* name, int32_t least) {
  const auto pair = in.Ints(name, 2, least, kMaxExtentUm);
  return {pair[0], pair[1]};
}

Outline ReadOutline(ObjectReader& in, Outlines known) {
  const std::string name = in.Name("outline");
  const size_t count = known == Outlines::kAll ? 4 : 2;
  for (size_t i = 0; i < count; ++i)
    if (name == kNames[i]) return static_cast<Outline>(i);
  in.Refuse("outline", count == 2 ? "box or disc" : "box, disc, polygon or stump",
            "\"" + name + "\"");
  return Outline::kBox;
}

// Twice the area of a, b, c; positive when they go round counter-clockwise.
int64_t Turn(const Corner& a, const Corner& b, const Corner& c) {
  return (int64_t{b[0]} - a[0]) * (int64_t{c[1]} - a[1]) -
         (int64_t{b[1]} - a[1]) * (int64_t{c[0]} - a[0]);
}

bool Cross(const Corner& a, const Corner& b, const Corner& c, const Corner& d) {
  auto sign = [](int64_t v) { return (v > 0) - (v < 0); };
  return sign(Turn(a, b, c)) * sign(Turn(a, b, d)) < 0 &&
         sign(Turn(c, d, a)) * sign(Turn(c, d, b)) < 0;
}

void ReadCorners(ObjectReader& in, PreparationPart& part) {
  bool whole = true;
  for (const auto& row : in.Rows("corners_um", 2, kMaxCorners)) {
    whole = whole && std::all_of(row.begin(), row.end(), [](double v) {
              return v == std::floor(v) && std::fabs(v) <= kMaxExtentUm;
            });
    if (whole)
      part.corners_um.push_back({static_cast<int32_t>(row[0]), static_cast<int32_t>(row[1])});
  }
  if (!whole || !IsOutline(part.corners_um)) {
    in.Refuse("corners_um",
              "at least 3 corners in whole um, counter-clockwise, with sides that do not cross",
              "another outline");
    // Callers always get a polygon.
    part.corners_um = {{0, 0}, {1, 0}, {0, 1}};
  }
}

void ReadStump(ObjectReader& in, PreparationPart& part) {
  ObjectReader stump = in.Object("stump");
  auto section = [&](const char* name) {
    ObjectReader object = stump.Object(name);
    Stump::Section out{ReadPair(object, "middle_um", -kMaxExtentUm),
                       ReadPair(object, "half_um", 1)};
    object.Finish();
    return out;
  };
  Stump& s = part.stump;
  s.foot = section("foot");
  s.table = section("table");
  s.table_below_um = static_cast<int32_t>(stump.Int("table_below_um", 0, kMaxExtentUm));
  s.corner_um = static_cast<int32_t>(stump.Int("corner_um", 0, kMaxExtentUm));
  if (s.table_below_um >= part.depth_um) {
    stump.Refuse("table_below_um", "less than depth_um, " + std::to_string(part.depth_um),
                 std::to_string(s.table_below_um));
  }
  stump.Finish();
}

void ReadRelief(ObjectReader& in, PreparationPart& part) {
  ObjectReader object = in.Object("relief");
  Relief& r = part.relief;
  r.step_um = static_cast<int32_t>(object.Int("step_um", 10, kMaxExtentUm));
  const auto count = object.Ints("count", 2, 1, kMaxReliefSide);
  r.count = {count[0], count[1]};
  if (r.count[0] % 2 == 0 || r.count[1] % 2 == 0) {
    object.Refuse("count", "odd numbers, so that one point is the part's middle",
                  std::to_string(r.count[0]) + " and " + std::to_string(r.count[1]));
  }
  // A refused relief gets the expected size, so that callers can read it.
  r.below_um.assign(static_cast<size_t>(r.count[0]) * static_cast<size_t>(r.count[1]), 0);
  const auto below = object.Ints("below_um", r.below_um.size(), 0, part.depth_um);
  std::copy(below.begin(), below.end(), r.below_um.begin());
  object.Finish();
}

}  // namespace

bool IsOutline(const std::vector<Corner>& corners) {
  const size_t n = corners.size();
  if (n < 3) return false;
  int64_t area = 0;
  for (size_t i = 0; i < n; ++i) {
    area += Turn({0, 0}, corners[i], corners[(i + 1) % n]);
    if (corners[i] == corners[(i + 1) % n]) return false;
    for (size_t j = i + 1; j < n; ++j)
      if (Cross(corners[i], corners[(i + 1) % n], corners[j], corners[(j + 1) % n])) return false;
  }
  return area > 0;
}

json::object PartJson(const PreparationPart& part) {
  json::object out{{"outline", kNames[static_cast<size_t>(part.outline)]},
                   {"top_um", json::array{part.top_um[0], part.top_um[1], part.top_um[2]}}};
  if (part.outline == Outline::kDisc) {
    out["radius_um"] = part.half_size_um[0];
  } else if (part.outline == Outline::kPolygon) {
    json::array corners;
    for (const Corner& corner : part.corners_um) corners.push_back(PairJson(corner));
    out["corners_um"] = std::move(corners);
  } else {
    out["half_size_um"] = PairJson(part.half_size_um);
  }
  out["depth_um"] = part.depth_um;
  if (part.outline == Outline::kStump) {
    auto section = [](const Stump::Section& s) {
      return json::object{{"middle_um", PairJson(s.middle_um)}, {"half_um", PairJson(s.half_um)}};
    };
    out["stump"] = json::object{{"foot", section(part.stump.foot)},
                                {"table", section(part.stump.table)},
                                {"table_below_um", part.stump.table_below_um},
                                {"corner_um", part.stump.corner_um}};
  }
  if (part.relief.step_um != 0) {
    const Relief& r = part.relief;
    out["relief"] = json::object{{"step_um", r.step_um},
                                 {"count", PairJson(r.count)},
                                 {"below_um", json::array(r.below_um.begin(), r.below_um.end())}};
  }
  return out;
}

PreparationPart ReadPart(ObjectReader& in, Outlines known) {
  PreparationPart part;
  part.outline = ReadOutline(in, known);
  auto top = in.Ints("top_um", 3, -kMaxExtentUm, kMaxExtentUm);
  part.top_um = {top[0], top[1], top[2]};
  if (part.outline == Outline::kDisc) {
    auto radius = static_cast<int32_t>(in.Int("radius_um", 1, kMaxExtentUm));
    // A disc has one number; both places of the struct hold it, so that readers need not ask which
    // outline it is.
    part.half_size_um = {radius, radius};
  } else if (part.outline == Outline::kPolygon) {
    ReadCorners(in, part);
  } else {
    part.half_size_um = ReadPair(in, "half_size_um", 1);
  }
  part.depth_um = static_cast<int32_t>(in.Int("depth_um", 1, kMaxExtentUm));
  if (part.outline == Outline::kStump) ReadStump(in, part);
  if (known == Outlines::kAll && in.Has("relief")) ReadRelief(in, part);
  in.Finish();
  return part;
}

}  // namespace enamel::scene
