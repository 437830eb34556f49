#pragma once

#include "common/cutting/volume.h"
#include "common/scene/types.h"

// Volumes with what a scene does not need left out, and with nothing left out. All of them are the
// same tooth to a bur that stays within the reach: forces, cuts and state hash are equal bit for
// bit (tests/common/scene/pruning_test.cpp runs every built-in scene both ways).
// Thread safety: functions, any thread. Not real-time. Deterministic: integers only, so that two
// sides that prune the same volume by the same documents hold the same one.
namespace enamel::scene {

// Where an exercise's bur has work: an axis-aligned box, open upward, nm.
struct Reach {
  std::array<int64_t, 3> lo_nm{};
  std::array<int64_t, 3> hi_nm{};  // z unused
};

// The target with leeway and container around it, the bur's width and a margin of 2 mm on all sides
// for a hand that wanders. Requires: the exercise's landmark is in the scene.
Reach ReachOf(const Scene& scene, const Exercise& exercise);

// Labels that say nothing are dropped, bricks without a surface become one word, and bricks that
// the reach does not touch become air: they are not refined.
cutting::Volume Pruned(const cutting::Volume& volume, const Reach& reach);
// The same without a reach: nothing a bur could ever meet changes.
cutting::Volume Pruned(const cutting::Volume& volume);

// Every brick stored and labelled, air too: what a tooth costs when nothing is left out.
// Labels of bricks that were plain air say gypsum: no solid can ever be there.
cutting::Volume Unpruned(const cutting::Volume& volume);

// Without bricks that hold nothing but one tissue: to see what the tissue costs. Cutting near it is
// not the same any more.
cutting::Volume Without(const cutting::Volume& volume, cutting::Tissue tissue);

}  // namespace enamel::scene
