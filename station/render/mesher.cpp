#include "station/render/mesher.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "station/render/revolve.h"
#include "station/render/simplify.h"

namespace enamel::station::render {
namespace {

// A change sends its whole group again, and each group is a call to the driver: larger groups cost
// more of the first, smaller ones more of the second. 'enamel-lab bench frames' measures both
// together.
constexpr int kGroupSide = 4;
// Error of uncut surface in the picture: a third of a pixel, seen near.
constexpr float kUncutError_mm = 0.004f;
// While the picture moves: half a pixel, seen as at the start of an attempt.
constexpr float kMovingError_mm = 0.012f;
// The tick thread cannot wake the mesher without a system call, so the mesher polls.
constexpr auto kPollInterval = std::chrono::milliseconds(4);

int8_t ToInt8(float v) {
  return static_cast<int8_t>(std::lround(std::clamp(v, -1.0f, 1.0f) * 127));
}

ivec3 BrickAt(const cutting::GridSpec& spec, int brick) {
  return {brick % spec.bricks.x, brick / spec.bricks.x % spec.bricks.y,
          brick / (spec.bricks.x * spec.bricks.y)};
}

glm::vec3 PositionOf(const GpuVertex& v) {
  return {v.position_mm[0], v.position_mm[1], v.position_mm[2]};
}

// Calls visit(unit normal) for each triangle that has one.
template <typename Visit>
void ForEachNormal(std::span<const GpuVertex> vertices, std::span<const uint32_t> indices,
                   Visit&& visit) {
  for (size_t i = 0; i + 2 < indices.size(); i += 3) {
    glm::vec3 a = PositionOf(vertices[indices[i]]);
    glm::vec3 n = glm::cross(PositionOf(vertices[indices[i + 1]]) - a,
                             PositionOf(vertices[indices[i + 2]]) - a);
    float length = glm::length(n);
    if (length > 0) visit(n / length);
  }
}

// `finish(vertex, i)`: what else the i-th vertex has.
template <typename Finish>
void AppendWith(const surface::Mesh& part, GroupMesh& mesh, Finish&& finish) {
  auto base = static_cast<uint32_t>(mesh.vertices.size());
  for (size_t i = 0; i < part.position_m.size(); ++i) {
    glm::vec3 p = part.position_m[i] * 1000.0f, n = part.normal[i];
    GpuVertex vertex{{p.x, p.y, p.z}, {ToInt8(n.x), ToInt8(n.y), ToInt8(n.z)}, part.tissue[i]};
    finish(vertex, i);
    mesh.vertices.push_back(vertex);
  }
  for (const auto& t : part.triangles) {
    for (uint32_t i : t) mesh.indices.push_back(base + i);
  }
}

}  // namespace

void Append(const surface::Mesh& part, std::span<const uint8_t> materials, GroupMesh& mesh) {
  AppendWith(part, mesh, [&](GpuVertex& vertex, size_t i) { vertex.tissue = materials[i]; });
}

void Append(const surface::Mesh& part, const ToothLooks& looks, GroupMesh& mesh) {
  AppendWith(part, mesh, [&](GpuVertex& vertex, size_t i) {
    if (!ToothLooks::IsTooth(vertex.tissue)) return;
    vertex.look = looks.At(dvec3(part.position_m[i]), dvec3(part.normal[i]),
                           static_cast<cutting::Tissue>(vertex.tissue));
    vertex.tissue = kTooth;
  });
}

Bounds BoundsOf(std::span<const GpuVertex> vertices, std::span<const uint32_t> indices) {
  Bounds out;
  if (vertices.empty()) return out;
  glm::vec3 lo = PositionOf(vertices[0]), hi = lo, sum(0);
  for (const GpuVertex& v : vertices) {
    lo = glm::min(lo, PositionOf(v));
    hi = glm::max(hi, PositionOf(v));
  }
  out.middle_mm = 0.5f * (lo + hi);
  out.radius_mm = 0.5f * glm::length(hi - lo);
  ForEachNormal(vertices, indices, [&](const glm::vec3& n) { sum += n; });
  float length = glm::length(sum);
  // Normals that cancel, as of a closed surface: no axis, so it may be seen from anywhere.
  if (length < 1e-3f) return out;
  out.axis = sum / length;
  float least = 1;
  ForEachNormal(vertices, indices,
                [&](const glm::vec3& n) { least = std::min(least, glm::dot(n, out.axis)); });
  // The thousandth is for rounding: the result is never false by mistake.
  out.spread_rad = std::acos(std::clamp(least, -1.0f, 1.0f)) + 1e-3f;
  return out;
}

bool MayFace(const Bounds& bounds, const glm::vec3& eye_mm) {
  glm::vec3 to_middle = bounds.middle_mm - eye_mm;
  float distance = glm::length(to_middle);
  if (distance <= bounds.radius_mm) return true;
  // A triangle faces away when its normal is less than a right angle from the line of sight; lines
  // of sight to the sphere differ by the sphere's angle.
  float open = bounds.spread_rad + std::asin(bounds.radius_mm / distance);
  constexpr float kRightAngle = 1.5707963f;
  return open >= kRightAngle || glm::dot(bounds.axis, to_middle) / distance <= std::sin(open);
}

Mesher::Mesher(const cutting::Volume& initial, BrickFeed& feed, VolumeWatch watch,
               const cutting::Volume* uncut)
    : feed_(feed),
      watch_(std::move(watch)),
      cut_already_(uncut != nullptr && uncut != &initial),
      groups_((initial.spec().bricks + kGroupSide - 1) / kGroupSide),
      replica_(initial),
      looks_(replica_, uncut),
      bricks_(initial.spec()) {
  replica_.Reserve();
  auto bricks = static_cast<size_t>(initial.spec().brick_count());
  bricks_of_group_.resize(group_count());
  for (size_t b = 0; b < bricks; ++b) {
    auto brick = static_cast<int>(b);
    bricks_of_group_[GroupOf(BrickAt(initial.spec(), brick))].push_back(brick);
  }
  thread_ = std::thread([this] { Run(); });
}

Mesher::~Mesher() {
  stop_ = true;
  thread_.join();
}

size_t Mesher::GroupOf(const ivec3& brick) const {
  ivec3 g = brick / kGroupSide;
  return (static_cast<size_t>(g.z) * groups_.y + g.y) * groups_.x + g.x;
}

std::vector<GroupMesh> Mesher::TakeReady() {
  MutexLock lock(mutex_);
  return std::exchange(ready_, {});
}

bool Mesher::WaitIdle(std::chrono::milliseconds limit) {
  size_t target = feed_.sent();
  MutexLock lock(mutex_);
  return idle_.wait_for(
      mutex_, limit, [&]() ENAMEL_REQUIRES(mutex_) { return initial_done_ && meshed_ >= target; });
}

void Mesher::Run() {
  MeshInitial();
  while (!stop_) {
    LetWatch();
    if (!ApplyUpdates()) {
      if (!CoarsenOne()) std::this_thread::sleep_for(kPollInterval);
      continue;
    }
    RemeshChanged();
    {
      MutexLock lock(mutex_);
      // After the meshes were delivered: a thread that waits for this number finds them.
      meshed_ = applied_;
    }
    idle_.notify_all();
  }
}

void Mesher::LetWatch() {
  auto now = std::chrono::steady_clock::now();
  if (!watch_ || watched_ == applied_ || now - watched_at_ < kWatchInterval) return;
  watch_(replica_);
  watched_ = applied_;
  watched_at_ = std::chrono::steady_clock::now();
}

void Mesher::MeshInitial() {
  for (size_t g = 0; g < group_count() && !stop_; ++g) {
    bricks_.Renew(replica_, bricks_of_group_[g]);
    GroupMesh mesh = Assemble(g);
    // Before Simplify, which would leave no recognisable edges (simplify.h).
    Coarsen(mesh, kMovingError_mm);
    Simplify(mesh, kUncutError_mm);
    if (!mesh.indices.empty()) Deliver(std::move(mesh));
  }
  // WaitIdle returns once what was removed before is measured.
  if (watch_ && cut_already_ && !stop_) watch_(replica_);
  {
    MutexLock lock(mutex_);
    initial_done_ = true;
  }
  idle_.notify_all();
}

bool Mesher::ApplyUpdates() {
  size_t taken = feed_.Drain([&](const BrickUpdate& update) {
    if (!replica_.Materialise(update.brick)) return;
    replica_.MutablePhi(update.brick) = update.phi;
    changed_.push_back(update.brick);
  });
  applied_ += taken;
  return taken > 0;
}

void Mesher::RemeshChanged() {
  std::vector<size_t> groups;
  for (int32_t b : bricks_.Update(replica_, changed_)) {
    groups.push_back(GroupOf(BrickAt(replica_.spec(), b)));
  }
  changed_.clear();
  std::sort(groups.begin(), groups.end());
  groups.erase(std::unique(groups.begin(), groups.end()), groups.end());
  for (size_t g : groups) Deliver(Assemble(g));
  without_coarse_.insert(without_coarse_.end(), groups.begin(), groups.end());
  std::sort(without_coarse_.begin(), without_coarse_.end());
  without_coarse_.erase(std::unique(without_coarse_.begin(), without_coarse_.end()),
                        without_coarse_.end());
  changed_at_ = std::chrono::steady_clock::now();
}

bool Mesher::CoarsenOne() {
  if (without_coarse_.empty() || std::chrono::steady_clock::now() - changed_at_ < kRest) {
    return false;
  }
  GroupMesh mesh = Assemble(without_coarse_.back());
  without_coarse_.pop_back();
  Coarsen(mesh, kMovingError_mm);
  mesh.same_surface = true;
  Deliver(std::move(mesh));
  return true;
}

GroupMesh Mesher::Assemble(size_t group) const {
  GroupMesh out;
  out.group = group;
  for (int32_t b : bricks_of_group_[group]) Append(bricks_.at(b), looks_, out);
  out.bounds = BoundsOf(out.vertices, out.indices);
  return out;
}

void Mesher::Deliver(GroupMesh mesh) {
  MutexLock lock(mutex_);
  for (GroupMesh& waiting : ready_) {
    if (waiting.group == mesh.group) {
      // The waiting mesh was never drawn: if its surface was new, it still is.
      mesh.same_surface &= waiting.same_surface;
      waiting = std::move(mesh);
      return;
    }
  }
  ready_.push_back(std::move(mesh));
}

}  // namespace enamel::station::render
