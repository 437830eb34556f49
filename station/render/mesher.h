#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <span>
#include <thread>
#include <vector>

#include "common/base/mutex.h"
#include "common/cutting/volume.h"
#include "common/surface/brick_meshes.h"
#include "station/render/brick_feed.h"
#include "station/render/tooth_looks.h"

namespace enamel::station::render {

// A vertex in the graphics card's format. Position in millimetres, scene frame.
struct GpuVertex {
  float position_mm[3];
  int8_t normal[3];  // 127 = 1
  uint8_t tissue;    // or Material (revolve.h)
  Look look{};       // of kTooth
};
static_assert(sizeof(GpuVertex) == 20);

// A mesh's place and the directions of its triangles, so that hidden ones are not drawn.
struct Bounds {
  glm::vec3 middle_mm{0};
  float radius_mm = 0;
  glm::vec3 axis{0, 0, 1};  // every triangle's normal is within `spread_rad` of it
  float spread_rad = 4;     // more than pi: all directions
};
Bounds BoundsOf(std::span<const GpuVertex> vertices, std::span<const uint32_t> indices);
// False when no triangle is visible from `eye_mm`, all facing away. Never false by mistake.
bool MayFace(const Bounds& bounds, const glm::vec3& eye_mm);

// The surface of 4 x 4 x 4 bricks, replaced as a whole when one of them changes. Until then it is
// drawn with fewer triangles (simplify.h).
struct GroupMesh {
  size_t group = 0;
  std::vector<GpuVertex> vertices;
  std::vector<uint32_t> indices;
  std::vector<uint32_t> coarse;  // for a moving picture; empty: not made yet
  Bounds bounds;
  bool same_surface = false;  // same as the previous one: only `coarse` is new
};

// Add a mesh: with the material of each of its vertices, or as a tooth whose tissues look so.
// `mesh.bounds` are as before.
void Append(const surface::Mesh& part, std::span<const uint8_t> materials, GroupMesh& mesh);
void Append(const surface::Mesh& part, const ToothLooks& looks, GroupMesh& mesh);

// Called with the replica on the mesher's thread after it has changed, at most every
// kWatchInterval, to measure what was removed. The picture waits meanwhile. A tooth that is cut
// already is also shown to it before the first picture.
using VolumeWatch = std::function<void(const cutting::Volume& now)>;
inline constexpr std::chrono::milliseconds kWatchInterval{500};

// Keeps a replica of the volume up to date from a BrickFeed, on its own thread, and meshes the
// changes (surface::BrickMeshes). Bricks of one cut arrive within a few milliseconds of each other,
// so a picture may show a step between them for one frame. Changed groups get coarse triangles once
// nothing has changed for kRest. Thread safety: TakeReady, WaitIdle from any thread. Not real-time.
class Mesher {
 public:
  static constexpr std::chrono::milliseconds kRest{250};

  // Copies `initial`. `feed` must outlive the mesher, which is its consumer.
  // `uncut`: as ToothLooks takes it; a different volume than `initial` says that `initial` is cut.
  Mesher(const cutting::Volume& initial, BrickFeed& feed, VolumeWatch watch = {},
         const cutting::Volume* uncut = nullptr);
  ~Mesher();
  Mesher(const Mesher&) = delete;
  Mesher& operator=(const Mesher&) = delete;

  size_t group_count() const { return static_cast<size_t>(groups_.x) * groups_.y * groups_.z; }
  // Groups meshed since the last call; at most one entry per group.
  std::vector<GroupMesh> TakeReady();
  // Waits until the initial volume and everything the feed has sent are meshed. False on time-out.
  bool WaitIdle(std::chrono::milliseconds limit);

 private:
  void Run();
  void MeshInitial();
  bool ApplyUpdates();  // false when there were none
  void RemeshChanged();
  bool CoarsenOne();  // false when there is nothing to do
  void LetWatch();
  GroupMesh Assemble(size_t group) const;
  void Deliver(GroupMesh mesh);
  size_t GroupOf(const ivec3& brick) const;

  // Constant after construction.
  BrickFeed& feed_;
  const VolumeWatch watch_;
  const bool cut_already_;
  ivec3 groups_{0};
  // Owned by the mesher's thread.
  cutting::Volume replica_;
  const ToothLooks looks_;
  surface::BrickMeshes bricks_;
  std::vector<std::vector<int32_t>> bricks_of_group_;
  std::vector<int32_t> changed_;
  size_t applied_ = 0, watched_ = 0;
  std::chrono::steady_clock::time_point watched_at_{}, changed_at_{};
  std::vector<size_t> without_coarse_;  // groups, each once
  Mutex mutex_;
  std::condition_variable_any idle_;
  std::vector<GroupMesh> ready_ ENAMEL_GUARDED_BY(mutex_);
  size_t meshed_ ENAMEL_GUARDED_BY(mutex_) = 0;  // updates included in the picture
  bool initial_done_ ENAMEL_GUARDED_BY(mutex_) = false;

  std::atomic<bool> stop_{false};
  std::thread thread_;
};

}  // namespace enamel::station::render
