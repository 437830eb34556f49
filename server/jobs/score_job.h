#pragma once

#include <functional>

#include "common/base/result.h"
#include "common/base/uuid.h"
#include "server/jobs/reference_cache.h"
#include "server/storage/store.h"

namespace enamel::server {

// Told how far a job is, 0..1; returning false stops it (the server shuts down).
using JobProgress = std::function<bool(double progress)>;

// Scores one sealed attempt from stored data alone:
//  1. header, chunks and seal: signatures, chain and counts must agree;
//  2. scene, exercise and profile: they must give the header's parameters (CheckParams in
//     scene/delay.h). The newest correction of the exercise's rubric replaces its own;
//  3. the references of the exercise (ReferenceRows::Counting), and its own target: the kindest counts. An attempt that
//     was recorded as a reference is compared with itself. Where there was no reference, ReferenceRows::AddReference
//     queues the attempts again;
//  4. the core re-run on the recorded inputs: every witness and every state hash must agree. A
//     mismatch fails the attempt with the tick and chunk where it broke; nothing is scored. An exam
//     with a time limit is judged by its state when its time, gaps included, was up; later ticks
//     are still replayed and checked;
//  5. metrics, rubric, where and when points were lost (scoring/deductions.h), and four blobs:
//     score JSON (schemas/score.md), final volume as a change of the scene's, deviation by cells,
//     series (common/scoring/movement/series.h); then ResultRows::FinishAttempt;
//  6. the motion, and the nearest earlier one at the same exercise (scoring/motion.h): a flag for
//     reviewers, no points.
// Running it again gives the same blobs.
//
// `key`: signs the result (schemas/result.md); null: it stays unsigned. A score with the points and
// reasons of the previous one is stored as the same, so that it withdraws no release.
//
// `lease`: the lease of this run. It stops the run when somebody cancels it or another worker has
// its job, and keeps its cause; zero: none. Returns Ok when the attempt has its verdict: scored, or
// failed with its problem stored. Errors, after which the job should be tried again: kStorage,
// kUnavailable (also when `progress` stopped it); kNotFound when there is no such attempt. Thread
// safety: any thread. Blocks for seconds.
Status RunScoreJob(Store& store, const Uuid& attempt, const JobProgress& progress = {},
                   ReferenceCache* cache = nullptr, const Uuid& lease = {},
                   const trace::KeyPair* key = nullptr);

}  // namespace enamel::server
