#include <algorithm>

#include "common/core/core.h"

// Saving and restoring a core between two ticks.
namespace enamel::core {

bool Core::VisitState(StateArchive& archive) {
  size_t bur = bur_;
  archive(bur);
  if (!archive.ok() || bur >= engagements_.size()) return false;
  // Before what the bur in use knows is restored.
  if (!archive.saving()) UseBur(bur);
  archive(orientation_, started_, bur_on_, suspended_, free_ticks_, removed_, hash_, ticks_,
          wishes_);
  archive(half_cut_, has_half_cut_, sampled_, sample_valid_, reserve_exhausted_, resisting_n_,
          drag_n_m_);
  handpiece_.VisitState(archive);
  sweep_.VisitState(archive);
  coupling_.VisitState(archive);
  cues_.VisitState(archive);
  if (torque_) turning_.VisitState(archive);
  cutter_.VisitState(archive);
  engagement().VisitState(archive);
  // Of the ring, only the waiting bricks, from the front. Their order is state: it decides which
  // eight the next tick hashes.
  const size_t capacity = dirty_ring_.size();
  std::vector<int32_t> waiting(dirty_count_);
  for (size_t i = 0; i < dirty_count_; ++i) {
    waiting[i] = dirty_ring_[(dirty_head_ + i) % capacity];
  }
  auto count = static_cast<uint64_t>(waiting.size());
  archive(count);
  if (!archive.ok() || count > capacity) return false;
  waiting.resize(count);
  archive(waiting);
  if (archive.saving()) return true;
  std::fill(is_dirty_.begin(), is_dirty_.end(), uint8_t{0});
  std::fill(is_touched_.begin(), is_touched_.end(), uint8_t{0});
  touched_count_ = dirty_head_ = 0;
  dirty_count_ = waiting.size();
  for (size_t i = 0; i < waiting.size(); ++i) {
    if (waiting[i] < 0 || static_cast<size_t>(waiting[i]) >= capacity) return false;
    dirty_ring_[i] = waiting[i];
    is_dirty_[static_cast<size_t>(waiting[i])] = 1;
  }
  return archive.Complete();
}

bool Core::RestoreBrick(int brick, std::span<const int16_t, cutting::kBrickVoxels> phi) {
  // A brick may get another slot here than it had in the run that was saved. Nothing depends on
  // slots: all that counts goes by the brick's number.
  if (brick < 0 || brick >= volume_.spec().brick_count() || !volume_.Materialise(brick)) {
    return false;
  }
  std::copy(phi.begin(), phi.end(), volume_.MutablePhi(brick).phi.begin());
  return true;
}

}  // namespace enamel::core
