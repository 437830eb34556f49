#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "common/base/result.h"
#include "server/storage/actor.h"
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

// Scoring many attempts again: a batch and one job per attempt (job_store.h).
// A part of Store (store.h), which says what holds for all parts.
class BatchStore {
 public:
  virtual ~BatchStore() = default;

  // Scores these attempts again, after runs that were asked for one by one: somebody waits for
  // those. Left out, and counted in `left_out`: of which a run is waiting already, which have no
  // recording, and which failed or are held back. Title, cause and cohort of `row` count. Errors: kConflict
  // when none is left.
  virtual Result<BatchRow> RescoreTogether(const BatchRow& row, const std::vector<Uuid>& attempts,
                                           uint32_t& left_out, const Actor& by) = 0;
  // Newest first, at most 100.
  virtual Result<std::vector<BatchRow>> Batches() = 0;
  virtual Result<BatchRow> BatchById(const Uuid& id) = 0;
  // Every job of it that is not over, as CancelJob.
  virtual Status CancelBatch(const Uuid& id, const Actor& by) = 0;
};

}  // namespace enamel::server
