#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "common/base/result.h"
#include "common/base/uuid.h"
#include "server/storage/audit/actor.h"
#include "server/storage/engine/transactions.h"
#include "server/training/types.h"

namespace enamel::server {

// Scoring runs that were asked for together, and what became of them.
struct BatchRow {
  Uuid id;
  std::string title;  // for people
  std::string cause;
  std::optional<Uuid> cohort{};  // whose attempts they are: who teaches it may see this
  UnixMs queued_ms = 0;
  uint32_t queued = 0, running = 0, done = 0, failed = 0, cancelled = 0;

  bool over() const { return queued + running == 0; }
};

// Scoring many attempts again: a batch and one job per attempt (job_rows.h).
class BatchRows {
 public:
  explicit BatchRows(Transactions& rows) : rows_(rows) {}

  // Scores these attempts again, after runs that were asked for one by one: somebody waits for
  // those. Left out, and counted in `left_out`: of which a run is waiting already, which have no
  // recording, and which failed or are held back. Title, cause and cohort of `row` count. Errors:
  // kConflict when none is left.
  Result<BatchRow> RescoreTogether(const BatchRow& row, const std::vector<Uuid>& attempts,
                                   uint32_t& left_out, const Actor& by);
  // Newest first, at most 100.
  Result<std::vector<BatchRow>> Batches();
  Result<BatchRow> BatchById(const Uuid& id);
  // Every job of it that is not over, as CancelJob.
  Status CancelBatch(const Uuid& id, const Actor& by);

 private:
  Transactions& rows_;
};

}  // namespace enamel::server
