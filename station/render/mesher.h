#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <mutex>
#include <span>
#include <thread>
#include <vector>

#include "common/cutting/volume.h"
#include "common/surface/brick_meshes.h"
#include "station/render/brick_feed.h"

namespace enamel::station::render {

// A vertex as the graphics card takes it. Position in millimetres, scene frame.
struct GpuVertex {
  float position_mm[3];
  int8_t normal[3];  // 127 = 1
  uint8_t tissue;
};
static_assert(sizeof(GpuVertex) == 16);

// Where a mesh is and which way its triangles face, so that what cannot be seen is not drawn.
struct Bounds {
  glm::vec3 middle_mm{0};
  float radius_mm = 0;
  glm::vec3 axis{0, 0, 1};  // every triangle's normal is within `spread_rad` of it
  float spread_rad = 4;     // more than pi: all directions
};
Bounds BoundsOf(std::span<const GpuVertex> vertices, std::span<const uint32_t> indices);
// False when no triangle can be seen from `eye_mm`, all facing away. Never false by mistake.
bool MayFace(const Bounds& bounds, const glm::vec3& eye_mm);

// The surface of 4 x 4 x 4 bricks, replaced as a whole when one of them changes. Until then it is
// drawn with fewer triangles (simplify.h).
struct GroupMesh {
  size_t group = 0;
  std::vector<GpuVertex> vertices;
  std::vector<uint32_t> indices;
  std::vector<uint32_t> coarse;  // for a picture that moves; empty: not made yet
  Bounds bounds;
  bool same_surface = false;  // as the one before it: only `coarse` is new
};

// Sees the replica on the mesher's thread after it has changed, at most every kWatchInterval: for
// measuring what has gone. The picture waits meanwhile.
using VolumeWatch = std::function<void(const cutting::Volume& now)>;
inline constexpr std::chrono::milliseconds kWatchInterval{500};

// Keeps a replica of the volume up to date from a BrickFeed, on a thread of its own, and meshes
// what changed (surface::BrickMeshes). Bricks that a cut spreads over arrive
// within a few milliseconds of each other, so a picture may show a step between them for one frame.
// What was cut gets its coarse triangles once nothing has changed for kRest.
// Thread safety: TakeReady, WaitIdle from any thread. Not real-time.
class Mesher {
 public:
  static constexpr std::chrono::milliseconds kRest{250};

  // Copies `initial`. `feed` must outlive the mesher, which is its consumer.
  Mesher(const cutting::Volume& initial, BrickFeed& feed, VolumeWatch watch = {});
  ~Mesher();
  Mesher(const Mesher&) = delete;
  Mesher& operator=(const Mesher&) = delete;

  size_t group_count() const { return static_cast<size_t>(groups_.x) * groups_.y * groups_.z; }
  // Groups meshed since the last call; at most one entry per group.
  std::vector<GroupMesh> TakeReady();
  // Waits until all that the feed has sent, and the initial volume, is meshed. False on time-out.
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
  ivec3 groups_{0};
  // Owned by the mesher's thread.
  cutting::Volume replica_;
  surface::BrickMeshes bricks_;
  std::vector<std::vector<int32_t>> bricks_of_group_;
  std::vector<int32_t> changed_;
  size_t applied_ = 0, watched_ = 0;
  std::chrono::steady_clock::time_point watched_at_{}, changed_at_{};
  std::vector<size_t> without_coarse_;  // groups, each once
  // Guarded by mutex_.
  std::mutex mutex_;
  std::condition_variable idle_;
  std::vector<GroupMesh> ready_;
  size_t meshed_ = 0;  // updates that are in the picture
  bool initial_done_ = false;

  std::atomic<bool> stop_{false};
  std::thread thread_;
};

}  // namespace enamel::station::render
