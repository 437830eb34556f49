#pragma once

#include <cstdint>
#include <optional>
#include <set>
#include <vector>

#include "common/base/result.h"
#include "common/base/sha256.h"
#include "common/base/uuid.h"
#include "common/scoring/movement/hand_figures.h"
#include "server/storage/engine/query.h"
#include "server/storage/engine/transactions.h"

namespace enamel::server {

// A motion that is kept (schemas/motion.md). `content`: as StoredBlobs::PutAttemptBlob kept it.
struct MotionRow {
  Uuid attempt;
  Sha256 content;
  bool preset = false;  // a reference cut, or the work of a simulated hand
};

// Where an attempt's motion lies among those before it (scoring::Nearness).
struct NearAttempt {
  Uuid attempt;  // the nearest; zero: it is erased
  uint32_t others = 0;
  int64_t nearest_um = 0, median_um = 0, size_um = 0;
  bool worth_a_look = false;  // kNearAnother
  // The nearest of those that are preset paths: reference cuts and simulated hands. Zero: there was
  // none before it, or it is erased.
  Uuid preset;
  uint32_t presets = 0;
  int64_t preset_um = 0;

  bool operator==(const NearAttempt&) const = default;
};

// A motion under an assignment: what is compared between its attempts.
struct AssignedMotion {
  Uuid attempt;
  scoring::HandRecord record;
};

struct AttemptResult;  // result_rows.h

// The motions of attempts, and how near they lie to others (schemas/motion.md).
class MotionRows {
 public:
  explicit MotionRows(Transactions& rows) : rows_(rows) {}

  // The motions at the same exercise, any version of it on the same scene, that were sealed before
  // this attempt's; the newest `limit`, preset paths first. Anybody's.
  Result<std::vector<MotionRow>> MotionsBefore(const Uuid& attempt, uint32_t limit);
  // Of the assignment's attempts that are not excused; the newest `limit`.
  Result<std::vector<AssignedMotion>> MotionsUnder(const Uuid& assignment, uint32_t limit);
  // None if there was no earlier one, or the recording was removed.
  Result<std::optional<NearAttempt>> NearestTo(const Uuid& attempt);

 private:
  Transactions& rows_;
};

// Inside a transaction, for other rows.
//
// Stores a run's result about the motion, with its flag.
Status KeepMotion(Db& db, const Uuid& attempt, const AttemptResult& result);
// It goes, its blob into `blobs`.
Status DropMotion(Db& db, const Uuid& attempt, std::set<Sha256>& blobs);

}  // namespace enamel::server
