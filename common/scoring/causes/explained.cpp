#include "common/scoring/causes/explained.h"

#include <algorithm>
#include <cmath>

namespace enamel::scoring {
namespace {

// Less of a patch's own surface says nothing of how it lies.
constexpr double kLeastPatch_m2 = 0.2e-6;
// Vertices that face as a wall does, and lie this near to it, lie on it: its round ends.
constexpr double kBesideWall_m = 0.7e-3;
// Patches that face alike are two where nothing lies between them over this much of the way that
// they face.
constexpr double kApart_m = 0.3e-3;
// A wave's crest, with some room: 1.41 of its root mean square.
constexpr double kCrest = 1.7;

int FacingOf(const dvec3& n) {
  int axis = 0;
  for (int i = 1; i < 3; ++i) {
    if (std::fabs(n[i]) > std::fabs(n[axis])) axis = i;
  }
  return 2 * axis + (n[axis] < 0 ? 1 : 0);
}

double HeightAt_m(const Patch& patch, const dvec3& point_m, bool left) {
  return patch.sheet.At_m(point_m) * (left ? -1 : 1) + kCrest * patch.sheet.waves_m;
}

double Length(const dvec3& v) { return std::sqrt(Dot(v, v)); }

}  // namespace

Explained::Explained(const Walls& walls, const CauseInputs& inputs)
    : in_(inputs), voxel_m_(inputs.reference.volume->spec().voxel_m()) {
  Assign(walls);
  for (Patch& patch : patches_) {
    if (patch.part == kNoPart) Fit(patch);
    Measure(patch);
  }
  Sort();
}

void Explained::Assign(const Walls& walls) {
  const surface::Mesh& mesh = *in_.reference.mesh;
  const auto& cut = *in_.reference.cut;
  patch_of_.assign(mesh.position_m.size(), -1);
  // Walls and floor that the attempt has made.
  std::array<dvec3, kPartCount> middle{};
  for (size_t p = 0; p < kPartCount; ++p) {
    patches_.push_back({walls[p].over, static_cast<Part>(p), FacingOf(walls[p].over.normal), {}});
  }
  std::vector<size_t> others;
  for (size_t i = 0; i < mesh.position_m.size(); ++i) {
    if (!cut[i]) continue;
    const dvec3 at(mesh.position_m[i]), facing(mesh.normal[i]);
    const Part part = PartOf(in_.target, in_.depth_m, at, facing);
    if (part == kNoPart || !walls[part].in_task || !walls[part].made) {
      others.push_back(i);
      continue;
    }
    patch_of_[i] = part;
    patches_[part].vertices.push_back(i);
    patches_[part].area_m2 += (*in_.reference.areas_m2)[i];
    middle[part] += at;
  }
  std::array<std::vector<size_t>, kPartCount> beside;
  std::array<std::vector<size_t>, 6> loose;
  for (size_t i : others) {
    const dvec3 at(mesh.position_m[i]);
    const int facing = FacingOf(dvec3(mesh.normal[i]));
    for (size_t p = 0; p < kPartCount && patch_of_[i] < 0; ++p) {
      const Patch& wall = patches_[p];
      if (wall.vertices.empty() || wall.facing != facing) continue;
      const dvec3 from = at - middle[p] / static_cast<double>(wall.vertices.size());
      if (std::fabs(Dot(from, wall.sheet.normal)) < kBesideWall_m) {
        patch_of_[i] = static_cast<int>(p);
        beside[p].push_back(i);
      }
    }
    if (patch_of_[i] < 0) loose[static_cast<size_t>(facing)].push_back(i);
  }
  for (size_t p = 0; p < kPartCount; ++p) Join(beside[p], patches_[p]);
  for (int facing = 0; facing < 6; ++facing) {
    std::vector<size_t>& of = loose[static_cast<size_t>(facing)];
    const int axis = facing / 2;
    std::stable_sort(of.begin(), of.end(), [&](size_t a, size_t b) {
      return mesh.position_m[a][axis] < mesh.position_m[b][axis];
    });
    size_t from = 0;
    for (size_t k = 1; k <= of.size(); ++k) {
      if (k < of.size() &&
          mesh.position_m[of[k]][axis] - mesh.position_m[of[k - 1]][axis] < kApart_m)
        continue;
      AddPatch({of.begin() + static_cast<ptrdiff_t>(from), of.begin() + static_cast<ptrdiff_t>(k)},
               facing);
      from = k;
    }
  }
}

// What is beside a wall or floor belongs to it. A floor with more beside it than it has itself is
// some of a round face, whose plane says nothing of the rest.
void Explained::Join(const std::vector<size_t>& beside, Patch& patch) {
  double area_m2 = 0;
  for (size_t i : beside) area_m2 += (*in_.reference.areas_m2)[i];
  if (patch.part == kFloor && area_m2 > patch.area_m2) patch.part = kNoPart;
  patch.area_m2 += area_m2;
  patch.vertices.insert(patch.vertices.end(), beside.begin(), beside.end());
}

void Explained::AddPatch(std::vector<size_t> vertices, int facing) {
  Patch patch{{}, kNoPart, facing, std::move(vertices)};
  for (size_t i : patch.vertices) patch.area_m2 += (*in_.reference.areas_m2)[i];
  if (patch.area_m2 < kLeastPatch_m2) return;
  for (size_t i : patch.vertices) patch_of_[i] = static_cast<int>(patches_.size());
  patches_.push_back(std::move(patch));
}

// By nearest distances: these patches may be round.
void Explained::Fit(Patch& patch) const {
  const surface::Mesh& mesh = *in_.reference.mesh;
  dvec3 normal(0);
  for (size_t i : patch.vertices) normal += dvec3(mesh.normal[i]) * (*in_.reference.areas_m2)[i];
  Sheet& sheet = patch.sheet;
  sheet.normal = normal / Length(normal);
  sheet.up = patch.upright() ? dvec3(0, 0, 1) : dvec3(1, 0, 0);
  sheet.up -= sheet.normal * Dot(sheet.up, sheet.normal);
  sheet.up /= Length(sheet.up);
  sheet.along = glm::cross(sheet.up, sheet.normal);
  std::vector<Height> heights;
  for (size_t i : patch.vertices) {
    const dvec3 p(mesh.position_m[i]);
    heights.push_back({-double{in_.reference_m[i]}, (*in_.reference.areas_m2)[i], Dot(p, sheet.up),
                       Dot(p, sheet.along)});
  }
  sheet.s_least_m = sheet.s_most_m = heights.front().s;
  for (const Height& h : heights) {
    sheet.s_least_m = std::min(sheet.s_least_m, h.s);
    sheet.s_most_m = std::max(sheet.s_most_m, h.s);
  }
  std::vector<Height> most = heights;
  sheet.plane = FitPlaneToMost(most, 0.25 * voxel_m_);
  sheet.waves_m = WavesAbout(sheet.plane, heights, 0.25 * voxel_m_);
}

void Explained::Measure(Patch& patch) const {
  bool first = true;
  for (size_t i : patch.vertices) {
    const dvec3 p(in_.reference.mesh->position_m[i]);
    const double t = Dot(p, patch.sheet.along);
    patch.middle_m += p / static_cast<double>(patch.vertices.size());
    patch.t_least_m = first ? t : std::min(patch.t_least_m, t);
    patch.t_most_m = first ? t : std::max(patch.t_most_m, t);
    first = false;
  }
}

void Explained::Sort() {
  const auto& at = in_.reference.mesh->position_m;
  dvec3 hi(0);
  bool any = false;
  for (size_t i = 0; i < patch_of_.size(); ++i) {
    if (patch_of_[i] < 0) continue;
    const dvec3 p(at[i]);
    lo_m_ = any ? glm::min(lo_m_, p) : p;
    hi = any ? glm::max(hi, p) : p;
    any = true;
  }
  if (!any) return;
  size_ = ivec3((hi - lo_m_) / kCell_m) + 1;
  auto cell = [&](const dvec3& p) {
    const ivec3 c((p - lo_m_) / kCell_m);
    return static_cast<size_t>((c.z * size_.y + c.y) * size_.x + c.x);
  };
  first_.assign(static_cast<size_t>(size_.x) * size_.y * size_.z + 1, 0);
  for (size_t i = 0; i < patch_of_.size(); ++i) {
    if (patch_of_[i] >= 0) ++first_[cell(dvec3(at[i])) + 1];
  }
  for (size_t c = 1; c < first_.size(); ++c) first_[c] += first_[c - 1];
  items_.resize(first_.back());
  std::vector<uint32_t> next(first_.begin(), first_.end() - 1);
  for (size_t i = 0; i < patch_of_.size(); ++i) {
    if (patch_of_[i] >= 0) items_[next[cell(dvec3(at[i]))]++] = static_cast<uint32_t>(i);
  }
}

Explanation Explained::At(const dvec3& point_m, const dvec3& normal, double distance_m,
                          bool left) const {
  if (items_.empty() || !(distance_m <= kFarthest_m)) return {};
  // At an edge the patch that lies elsewhere is farther than the nearest one. At the rim the nearest
  // is the tooth's own surface, which no patch is on.
  std::vector<double> most(patches_.size(), 0);
  double reach = 2 * (distance_m + voxel_m_);
  while (!Gather(point_m, reach, left, most) && reach <= kFarthest_m) reach *= 1.5;
  Behind(point_m, normal, left, most);
  // Where two patches meet, each by itself.
  double squares = 0;
  for (double m : most) squares += m * m;
  const auto largest = std::ranges::max_element(most);
  if (!(*largest > 0)) return {};
  Explanation out{std::sqrt(squares), &patches_[static_cast<size_t>(largest - most.begin())]};
  const auto walls = most.begin() + kPartCount;  // the first patches
  const auto wall = std::max_element(most.begin(), walls);
  if (*wall > 0.5 * distance_m) out.wall = &patches_[static_cast<size_t>(wall - most.begin())];
  return out;
}

// Where a patch moves by its height, a surface aslant to it moves by that times the cosine between.
void Explained::Behind(const dvec3& point_m, const dvec3& normal, bool left,
                       std::vector<double>& most) const {
  for (size_t k = 0; k < patches_.size(); ++k) {
    const Patch& patch = patches_[k];
    const Sheet& sheet = patch.sheet;
    const double cosine = Dot(normal, sheet.normal);
    if (patch.vertices.empty() || !(cosine > 0)) continue;
    const double s = Dot(point_m, sheet.up), t = Dot(point_m, sheet.along);
    if (s < sheet.s_least_m - kBesideWall_m || s > sheet.s_most_m + kBesideWall_m ||
        t < patch.t_least_m - kBesideWall_m || t > patch.t_most_m + kBesideWall_m)
      continue;
    if (std::fabs(Dot(point_m - patch.middle_m, sheet.normal)) > kFarthest_m) continue;
    most[k] = std::max(most[k], cosine * HeightAt_m(patch, point_m, left));
  }
}

// The largest height of each patch within reach; whether any patch is.
bool Explained::Gather(const dvec3& point_m, double reach_m, bool left,
                       std::vector<double>& most) const {
  const auto& at = in_.reference.mesh->position_m;
  const dvec3 from = (point_m - reach_m - lo_m_) / kCell_m;
  const dvec3 to = (point_m + reach_m - lo_m_) / kCell_m;
  ivec3 a, b;
  for (int i = 0; i < 3; ++i) {
    const auto last = static_cast<double>(size_[i] - 1);
    a[i] = static_cast<int>(std::clamp(std::floor(from[i]), 0.0, last));
    b[i] = static_cast<int>(std::clamp(std::floor(to[i]), -1.0, last));
  }
  bool any = false;
  for (int z = a.z; z <= b.z; ++z) {
    for (int y = a.y; y <= b.y; ++y) {
      const size_t row = static_cast<size_t>(z * size_.y + y) * size_.x;
      for (uint32_t k = first_[row + a.x]; b.x >= a.x && k < first_[row + b.x + 1]; ++k) {
        const dvec3 p(at[items_[k]]);
        if (Dot(p - point_m, p - point_m) > reach_m * reach_m) continue;
        any = true;
        const auto patch = static_cast<size_t>(patch_of_[items_[k]]);
        most[patch] = std::max(most[patch], HeightAt_m(patches_[patch], p, left));
      }
    }
  }
  return any;
}

}  // namespace enamel::scoring
