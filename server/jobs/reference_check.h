#pragma once

#include <string>

#include "common/base/result.h"
#include "common/cutting/volume.h"
#include "common/scene/types.h"
#include "server/storage/audit/actor.h"
#include "server/storage/judging/result_rows.h"
#include "server/storage/recordings/stored_blobs.h"
#include "server/storage/store.h"

// Checks that a reference meets the target of its exercise, which is independent of any attempt. A
// first reference is compared with nothing else: a cut that did a twentieth of the task would be
// marked 100 for it. Thread safety: functions, any thread; they block for the store.
namespace enamel::server {

// A cut beside its exercise's own target (schemas/score.md, "Zones").
struct TargetWork {
  double target_mm3 = 0;      // solid that the target asks to take
  double done_percent = 0;    // of it, what went
  double beside_mm3 = 0;      // what went anywhere beyond target and leeway, neighbours too
  double beside_percent = 0;  // that, of the target
};
// Requires: equal grids; a target's prepared tooth is loaded. Errors: those of scoring::BoxesOf.
Result<TargetWork> WorkOnTarget(const scene::Scene& scene, const scene::Exercise& exercise,
                                const cutting::Volume& initial,
                                const cutting::Volume& final_volume);

// The same of an attempt that is scored, read from the store. Errors: the store's and the
// documents'.
Result<TargetWork> WorkOfAttempt(StoredBlobs& blobs, ResultRows& results,
                                 const AttemptRow& attempt);

// Limits of a cut that others are compared with, chosen: the simulated dentist does more than nine
// tenths of every tooth's target and cuts nothing beside its leeway (`admin mark-reference` prints
// both). Somebody who stops early or cuts elsewhere does far less or far more. The margin is for
// other hands and coarser voxels.
inline constexpr double kMinDone_percent = 80, kMaxBeside_percent = 5;

// Whether an attempt that is scored may be what others are compared with: it did the task, and no
// more than the task, within the time, undisturbed, and was uploaded once. Errors: kConflict with
// field kAnyway and what to do; the store's.
Status CheckReferenceCut(StoredBlobs& blobs, ResultRows& results, const AttemptRow& attempt);

// Makes it the reference: CheckReferenceCut, unless `anyway` says why not, then
// ReferenceRows::AddReference. Errors: of both.
Result<ReferenceRow> MakeReference(Store& store, const Uuid& attempt, const std::string& dentist,
                                   bool consent, const std::string& anyway, const Actor& by);

}  // namespace enamel::server
