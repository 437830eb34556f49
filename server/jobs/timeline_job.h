#pragma once

#include "common/base/result.h"
#include "common/base/uuid.h"
#include "server/jobs/score_job.h"
#include "server/storage/store.h"

namespace enamel::server {

// Makes the surface timeline of a scored attempt (schemas/surface_timeline.md) and, once for a
// volume, its start tooth: the core re-run on the recorded inputs, all of them, also what came
// after an exam's limit. Outside the signed result. Running it again gives the same blobs.
//
// Returns Ok when it is stored, or its problem is: a recording that the replay disagrees with has
// no timeline. Errors, after which it should be tried again: kStorage, kUnavailable (also when
// `progress` stopped it). Thread safety: any thread. Blocks for seconds.
Status RunTimelineJob(Store& store, const Uuid& attempt, const JobProgress& progress = {});

}  // namespace enamel::server
