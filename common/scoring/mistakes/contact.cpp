#include "common/scoring/mistakes/contact.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "common/math/ramp.h"
#include "common/scene/tooth_number.h"
#include "common/scoring/brick_samples.h"
#include "common/scoring/changed.h"
#include "common/scoring/uncertainty.h"

namespace enamel::scoring {
namespace {

using cutting::kBrickSide;
using cutting::Tissue;
using cutting::Volume;

// A pillar in the box stands farther inside. Chosen: a bur's radius.
constexpr double kShell_m = 0.5e-3;
// A veneer's or a finish line's cut is not as deep as a box.
constexpr double kDeep_m = 1e-3;
constexpr double kMinContact_m2 = 0.1e-6;
// Thinner than the first is a grid's rounding, thicker than the second closes a row. Chosen: a strip of 0.1 mm does not
// pass where an examiner's probe of 0.25 mm should.
constexpr double kFilm_m = 0.02e-3, kClosed_m = 0.1e-3;
constexpr int32_t kWhole = 65536;

int Voxels(double length_m, double voxel_m) {
  return static_cast<int>(std::lround(length_m / voxel_m));
}
double ClosedShare(double left_m) { return Ramp(left_m, kFilm_m, kClosed_m); }

}  // namespace

Contact::Contact(const Volume& initial, const Volume& prepared, int tooth, scene::Up up)
    : initial_(initial), shell_(Voxels(kShell_m, initial.spec().voxel_m())) {
  FindRows(prepared);
  std::map<std::string, std::vector<uint32_t>> sides;
  const int mesial_x = scene::MesialX(tooth);
  for (size_t i = 0; i < rows_.size(); ++i) {
    sides[rows_[i].way == mesial_x ? "contact_mesial" : "contact_distal"].push_back(
        static_cast<uint32_t>(i));
  }
  third_.resize(rows_.size());
  for (auto& [side, rows] : sides) Divide(std::move(rows), side, up);
}

void Contact::FindRows(const Volume& prepared) {
  const cutting::GridSpec& spec = initial_.spec();
  const ChangedBricks task(initial_, prepared);
  const int gap = Voxels(kContactGap_m, spec.voxel_m());
  std::array<std::vector<Row>, 2> found;
  for (int b = 0; b < spec.brick_count(); ++b) {
    if (!task.Brick(b)) continue;
    const BrickSamples before(initial_, b), wanted(prepared, b);
    const ivec3 corner = ivec3(b % spec.bricks.x, b / spec.bricks.x % spec.bricks.y,
                               b / (spec.bricks.x * spec.bricks.y)) *
                         kBrickSide;
    for (int i = 0; i < cutting::kBrickVoxels; ++i) {
      if (wanted.Solid(i) >= before.Solid(i)) continue;
      const ivec3 at = corner + ivec3(i & 7, i >> 3 & 7, i >> 6);
      if (initial_.TissueAt(at) == Tissue::kNeighbour) continue;
      for (const int way : {1, -1}) {
        // The next solid sample outwards is of a neighbour.
        for (int step = 1; step <= gap + 1; ++step) {
          const ivec3 next = at + ivec3(way * step, 0, 0);
          if (cutting::SolidFraction(initial_.PhiAt(next)) == 0) continue;
          if (initial_.TissueAt(next) == Tissue::kNeighbour) TakeRow(prepared, at, way);
          break;
        }
      }
    }
  }
}

void Contact::TakeRow(const Volume& prepared, const ivec3& end, int way) {
  const cutting::GridSpec& spec = initial_.spec();
  const int deep = Voxels(kDeep_m, spec.voxel_m());
  // At the neighbour R may leave a flake of less than a voxel.
  for (int step = 1; step < deep; ++step) {
    const ivec3 at = end - ivec3(way * step, 0, 0);
    const bool own = initial_.PhiAt(at) < 0 && initial_.TissueAt(at) != Tissue::kNeighbour;
    if (!own || cutting::SolidFraction(prepared.PhiAt(at)) > 0) return;
  }
  const auto row = static_cast<uint32_t>(rows_.size()) + 1;
  rows_.push_back({end, way, cutting::SolidFraction(prepared.PhiAt(end))});
  for (int step = 0; step < shell_; ++step) {
    const ivec3 at = end - ivec3(way * step, 0, 0);
    const ivec3 in = at % kBrickSide;
    row_at_[spec.BrickIndex(at / kBrickSide)]
           [static_cast<size_t>((in.z * kBrickSide + in.y) * kBrickSide + in.x)] = row;
  }
}

void Contact::Divide(std::vector<uint32_t> rows, const std::string& side, scene::Up up) {
  const double h = initial_.spec().voxel_m();
  if (static_cast<double>(rows.size()) * h * h < kMinContact_m2) {
    for (const uint32_t row : rows) third_[row] = static_cast<uint32_t>(-1);
    return;
  }
  const bool of_face = up == scene::Up::kBuccal;
  auto height = [&](uint32_t row) { return of_face ? -rows_[row].end.y : rows_[row].end.z; };
  auto across = [&](uint32_t row) { return of_face ? rows_[row].end.z : rows_[row].end.y; };
  const auto third = rows.begin() + static_cast<std::ptrdiff_t>(rows.size() / 3);
  std::ranges::stable_sort(rows, {}, height);
  std::stable_sort(third, rows.end(),
                   [&](uint32_t a, uint32_t b) { return across(a) > across(b); });
  const auto half = third + (rows.end() - third) / 2;
  const std::array<std::pair<const char*, std::array<std::vector<uint32_t>::iterator, 2>>, 3>
      parts = {{{"_buccal", {third, half}},
                {"_gingival", {rows.begin(), third}},
                {"_lingual", {half, rows.end()}}}};
  for (const auto& [name, range] : parts) {
    Third& out = thirds_.emplace_back(Third{side + name});
    for (auto row = range[0]; row != range[1]; ++row) {
      third_[*row] = static_cast<uint32_t>(thirds_.size()) - 1;
      const ivec3 middle = rows_[*row].end - ivec3(rows_[*row].way * shell_ / 2, 0, 0);
      out.at_m += initial_.spec().origin_m() + dvec3(middle) * h;
      ++out.rows;
    }
    out.at_m /= out.rows;
  }
}

std::optional<uint32_t> Contact::RowAt(int brick, int i) const {
  const auto found = row_at_.find(brick);
  if (found == row_at_.end()) return {};
  const uint32_t row = found->second[static_cast<size_t>(i)];
  if (row == 0 || third_[row - 1] >= thirds_.size()) return {};
  return row - 1;
}

std::optional<uint32_t> Contact::ThirdAt(int brick, int i) const {
  const auto row = RowAt(brick, i);
  return row ? std::optional(third_[*row]) : std::nullopt;
}

Contact::Figures Contact::Of(const std::vector<double>& left_m, std::optional<size_t> third) const {
  const double half_m = 0.5 * initial_.spec().voxel_m();
  Figures out;
  std::map<int, double> at_height;
  for (size_t row = 0; row < rows_.size(); ++row) {
    if (third_[row] >= thirds_.size() || (third && third_[row] != *third)) continue;
    ++out.rows;
    out.closed += ClosedShare(left_m[row]);
    if (ClosedShare(left_m[row] + half_m) != ClosedShare(std::max(0.0, left_m[row] - half_m)))
      ++out.near;
    double& line = at_height[rows_[row].end.z];
    out.longest_line = std::max(out.longest_line, ++line);
  }
  return out;
}

Contact::Figures Contact::Of(const Volume& attempt) const {
  const double h = initial_.spec().voxel_m();
  std::vector<double> left_m(rows_.size());
  for (size_t row = 0; row < rows_.size(); ++row) {
    for (int step = 0; step < shell_; ++step) {
      const ivec3 at = rows_[row].end - ivec3(rows_[row].way * step, 0, 0);
      const int32_t most = cutting::SolidFraction(initial_.PhiAt(at));
      const int32_t left = std::min(most, cutting::SolidFraction(attempt.PhiAt(at)));
      left_m[row] += h * std::max(0, left - (step == 0 ? rows_[row].flake : 0)) / kWhole;
    }
  }
  return Of(left_m);
}

double Contact::Figures::uncertainty_percent(double surface_m, double voxel_m) const {
  if (!(rows > 0)) return 0;
  // Rows for a metre that the surface moves: of a voxel's range. Then a border along a line, which counts as a whole.
  const double moved = near / voxel_m * surface_m, counted = kEven * longest_line;
  return 100 * std::sqrt(moved * moved + counted * counted) / rows;
}

}  // namespace enamel::scoring
