#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "common/base/result.h"
#include "common/base/uuid.h"
#include "server/storage/audit/actor.h"
#include "server/storage/blobs/blobs.h"
#include "server/storage/engine/rewrite.h"
#include "server/storage/engine/transactions.h"
#include "server/storage/people/sign_in_rows.h"
#include "server/training/types.h"

namespace enamel::server {

// How long things are kept; no rule: for good.
//   "unfinished"  attempts that were never sealed, since their ticket; at least 14 days, as
//                 stations may still upload (schemas/wire/README.md)
//   "recordings"  since sealing: trace, final volume, deviation, timeline and force series go, the score stays
//   "attempts"    since sealing (quarantined ones: since their ticket): all of it
// Reference cuts, attempts with a job in the queue, with an appeal that waits for its answer, and
// students' graded work that is neither released nor excused are never touched; quarantined ones,
// being evidence, only by "attempts".
struct RetentionRule {
  std::string what;
  int32_t days = 0;
};

// Attempts a rule applies to now.
struct RetentionReport {
  std::vector<Uuid> unfinished, recordings, attempts;
  size_t blobs = 0;  // removed with them
  size_t held = 0;   // due as well, but kept for an appeal's answer or for their release
};

// Rules that say how long things are kept.
class RetentionRows {
 public:
  RetentionRows(Transactions& rows, Rewriter& rewriter, Blobs& blobs, SignInRows& sign_ins)
      : rows_(rows), rewriter_(rewriter), blobs_(blobs), sign_ins_(sign_ins) {}

  Result<std::vector<RetentionRule>> RetentionRules();
  // Days 0: no rule. Errors: kInvalidInput.
  Status SetRetention(const RetentionRule& rule, const Actor& by);
  // Removes what the rules say; with `dry_run` only tells. Errors: kUnavailable (a backup is
  // running).
  Result<RetentionReport> ApplyRetention(UnixMs now_ms, bool dry_run, const Actor& by);

 private:
  Transactions& rows_;
  Rewriter& rewriter_;
  Blobs& blobs_;
  SignInRows& sign_ins_;
};

}  // namespace enamel::server
