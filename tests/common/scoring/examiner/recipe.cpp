#include "tests/common/scoring/examiner/recipe.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <numbers>
#include <sstream>

#include "common/scene/preparation.h"

namespace enamel::scoring::examiner {
namespace {

constexpr double kMm = 1e3, kFar_mm = 99;
// Shapes that lean or wave are up to so many times nearer than their formula says.
constexpr double kErrs = 4;

double Sine(double at, double wave_length) {
  return std::sin(2 * std::numbers::pi * at / wave_length);
}
double Tangent(double degrees) { return std::tan(degrees * std::numbers::pi / 180); }

// How much of an error that one side alone has is found at p: 1 at the azimuth, 0 from a right angle on.
double ShareAt(const Shape& s, const dvec3& p, const char* azimuth, const char* power) {
  const double angle = std::atan2(p.y - s.Of("acy"), p.x - s.Of("acx"));
  const double away = angle - s.Of(azimuth) * std::numbers::pi / 180;
  return std::pow(std::max(0.0, std::cos(away)), s.Of(power, 4));
}

double Bounds(const Shape& s, const dvec3& p) {
  double out = -kFar_mm;
  const char* low[] = {"x0", "y0", "z0"};
  const char* high[] = {"x1", "y1", "z1"};
  for (int i = 0; i < 3; ++i) {
    out = std::max({out, s.Of(low[i], -kFar_mm) - p[i], p[i] - s.Of(high[i], kFar_mm)});
  }
  return out;
}

// A rectangle with round corners: lo and hi are its sides.
double RoundRectangle(double x, double y, const dvec3& lo, const dvec3& hi, double corner) {
  const double qx = std::fabs(x - 0.5 * (lo.x + hi.x)) - (0.5 * (hi.x - lo.x) - corner);
  const double qy = std::fabs(y - 0.5 * (lo.y + hi.y)) - (0.5 * (hi.y - lo.y) - corner);
  return std::hypot(std::max(qx, 0.0), std::max(qy, 0.0)) + std::min(std::max(qx, qy), 0.0) -
         corner;
}

}  // namespace

double Shape::Of(const std::string& key, double otherwise) const {
  const auto found = values.find(key);
  return found == values.end() ? otherwise : found->second;
}

std::vector<Recipe> ReadRecipes(const std::filesystem::path& path) {
  std::vector<Recipe> out;
  std::ifstream file(path);
  EXPECT_TRUE(file.is_open()) << path;
  for (std::string line; std::getline(file, line);) {
    const size_t bar = line.find('|');
    if (bar == std::string::npos) continue;
    Recipe recipe{line.substr(0, bar), {}};
    while (recipe.name.ends_with(' ')) recipe.name.pop_back();
    std::istringstream words(line.substr(bar + 1));
    for (std::string word; words >> word;) {
      const size_t equals = word.find('=');
      if (equals == std::string::npos)
        recipe.shapes.push_back({word, {}});
      else
        recipe.shapes.back().values[word.substr(0, equals)] = std::stod(word.substr(equals + 1));
    }
    out.push_back(std::move(recipe));
  }
  return out;
}

Carver::Carver(const scene::BuiltScene& built, const scene::Exercise& exercise)
    : built_(built), target_(*scene::TargetShape(built.scene, exercise.target)) {
  const auto at = *scene::TargetPoint(built.scene, exercise.target);
  landmark_mm_ = dvec3(at[0], at[1], at[2]) / kMm;
  half_mm_ = dvec3(exercise.target.half_size_um[0], exercise.target.half_size_um[1], 0) / kMm;
  depth_mm_ = exercise.target.depth_um / kMm;
  untouched_.emplace(surface::ExtractSurface(built.volume));
}

dvec3 Carver::Back(const Shape& s, dvec3 p) const {
  const dvec3 middle(s.Of("px"), s.Of("py"), s.Of("pz", -depth_mm_ / 2));
  p -= dvec3(s.Of("dx"), s.Of("dy"), s.Of("dz")) + middle;
  auto turn = [&](const char* key, int a, int b) {
    const double angle = -s.Of(key) * std::numbers::pi / 180;
    const double u = p[a], w = p[b];
    p[a] = std::cos(angle) * u - std::sin(angle) * w;
    p[b] = std::sin(angle) * u + std::cos(angle) * w;
  };
  turn("rz", 0, 1);
  turn("ry", 2, 0);
  turn("rx", 1, 2);
  return p + middle;
}

double Carver::Target(const Shape& s, const dvec3& p) const {
  double side = s.Of("side"), bottom = s.Of("bottom");
  if (s.Has("lean")) {
    side += Tangent(s.Of("lean")) * (p.z - s.Of("lz", -depth_mm_ / 2)) *
            (s.Has("laz") ? ShareAt(s, p, "laz", "lpw") : 1);
  }
  if (s.Has("sa")) side += s.Of("sa") * ShareAt(s, p, "saz", "spw");
  if (s.Has("wavz")) side += s.Of("wavz") * Sine(p.z, s.Of("wl", 0.8));
  if (s.Has("fw")) {
    bottom += s.Of("fw") * Sine(p.x, s.Of("fl", 1)) * Sine(p.y, s.Of("fl", 1));
  }
  bottom += s.Of("gx") * p.x + s.Of("gy") * p.y;
  if (s.Has("feather")) {
    const double down = std::clamp(s.Of("fz", 1 - depth_mm_) - p.z, 0.0, 1.2);
    side -= s.Of("feather") * down * (s.Has("faz") ? ShareAt(s, p, "faz", "fpw") : 1);
  }
  const dvec3 at_m = (p + landmark_mm_) / kMm;
  return scene::PreparationDistance_m(target_, at_m, {side / kMm, bottom / kMm}) * kMm;
}

double Carver::Box(const Shape& s, const dvec3& p) const {
  const double pivot = s.Of("piv", -depth_mm_ / 2);
  auto moved = [&](const char* by, const char* taper) {
    double out = s.Of(by) + Tangent(s.Of(taper)) * (p.z - pivot) + s.Of("all");
    if (s.Has("bevz")) out += std::max(0.0, p.z - s.Of("bevz")) * Tangent(s.Of("bev", 45));
    return out;
  };
  dvec3 hi(half_mm_.x + moved("dm", "tm"), half_mm_.y + moved("db", "tb"), 0);
  const dvec3 lo(-half_mm_.x - moved("dd", "td"), -half_mm_.y - moved("dl", "tl"), 0);
  const double length = s.Of("wl", 0.4);
  if (s.Has("wb")) hi.y += s.Of("wb") * Sine(p.x, length);
  double walls = RoundRectangle(p.x, p.y, lo, hi, s.Of("r", 0.5));
  if (s.Has("rough")) {
    const dvec3 out = p - 0.5 * (lo + hi), half = 0.5 * (hi - lo);
    const double along = std::fabs(out.x) - half.x > std::fabs(out.y) - half.y ? p.y : p.x;
    walls -= s.Of("rough") * Sine(along, length) * std::cos(2 * std::numbers::pi * p.z / length);
  }
  double floor_z =
      -depth_mm_ - s.Of("df") + Tangent(s.Of("ftx")) * p.x + Tangent(s.Of("fty")) * p.y;
  if (s.Has("fw")) {
    floor_z += s.Of("fw") * Sine(p.x, s.Of("fl", 1)) *
               std::cos(2 * std::numbers::pi * p.y / s.Of("fl", 1));
  }
  const double floor = floor_z - p.z, round = s.Of("rl");
  if (round > 0 && walls > -round && floor > -round) {
    return std::hypot(std::max(walls + round, 0.0), std::max(floor + round, 0.0)) - round;
  }
  return std::max(walls, floor);
}

double Carver::Shell(const Shape& s, const dvec3& p) const {
  const double thick = s.Of("t");
  return untouched_->Distance_m((p + landmark_mm_) / kMm, 2 * thick / kMm) * kMm - thick;
}

double Carver::Distance(const Shape& s, const dvec3& p) const {
  const double bounds = Bounds(s, p);
  // Nobody asks how far a point is beyond bounds.
  if (bounds > kErrs) return bounds;
  const dvec3 at = Back(s, p);
  std::string kind = s.kind;
  if (kind.front() == 'k') kind.erase(0, 1);
  double out = -kFar_mm;
  if (kind == "ref") out = Target(s, at);
  if (kind == "cav") out = Box(s, at);
  if (kind == "shell") out = Shell(s, p);
  if (kind == "sphere") {
    const dvec3 way = at - dvec3(s.Of("x"), s.Of("y"), s.Of("z"));
    out = std::sqrt(Dot(way, way)) - s.Of("r");
  }
  if (kind == "cyl") {
    out = std::max(std::hypot(at.x - s.Of("x"), at.y - s.Of("y")) - s.Of("r"),
                   s.Of("z", -kFar_mm) - at.z);
  }
  if (kind == "caps") {
    const dvec3 a(s.Of("ax"), s.Of("ay"), s.Of("az")), b(s.Of("bx"), s.Of("by"), s.Of("bz"));
    const dvec3 axis = b - a, way = at - a;
    const double along =
        Dot(axis, axis) > 0 ? std::clamp(Dot(way, axis) / Dot(axis, axis), 0.0, 1.0) : 0;
    const dvec3 off = way - along * axis;
    out = std::sqrt(Dot(off, off)) - s.Of("r", 0.5);
  }
  return std::max(out, bounds);
}

double Carver::All(const Recipe& recipe, const dvec3& p, bool neighbour) const {
  double out = kFar_mm;
  auto cut = [&](bool last) {
    for (const Shape& s : recipe.shapes) {
      if (s.kind.front() == 'k' || (s.Of("last") > 0) != last) continue;
      if (!neighbour || s.Of("nb") > 0) out = std::min(out, Distance(s, p));
    }
  };
  cut(false);
  for (const Shape& s : recipe.shapes) {
    if (s.kind.front() == 'k') out = std::max(out, -Distance(s, p));
  }
  cut(true);
  return out;
}

cutting::Volume Carver::Carve(const Recipe& recipe) const {
  const std::string& kind = recipe.shapes.at(0).kind;
  if (kind == "none") return built_.volume;
  if (kind == "exact") return scene::Prepared(built_.volume, target_, scene::Neighbours::kSpared);
  auto carved = [&](const cutting::Volume& from, bool neighbour) {
    auto distance_m = [&](const dvec3& at_m) {
      return All(recipe, at_m * kMm - landmark_mm_, neighbour) / kMm;
    };
    return scene::CutAway(from, distance_m, kErrs,
                          neighbour ? scene::Neighbours::kCut : scene::Neighbours::kSpared);
  };
  const cutting::Volume cut = carved(built_.volume, false);
  const bool nicked =
      std::ranges::any_of(recipe.shapes, [](const Shape& s) { return s.Of("nb") > 0; });
  return nicked ? carved(cut, true) : cut;
}

}  // namespace enamel::scoring::examiner
