#pragma once

#include <condition_variable>
#include <deque>
#include <stop_token>
#include <thread>
#include <vector>

#include "common/base/mutex.h"
#include "common/base/uuid.h"
#include "server/storage/engine/transactions.h"

namespace enamel::server {

// Chunk rows of sealed recordings, which nobody reads any more: their blob has them. A thread of
// its own deletes them in portions between the commits of others. Why not with the seal: the rows
// of stations that streamed at the same time are interleaved, each on a page that must be written;
// a class that seals together held up everybody's commits for seconds. The next process that runs
// Find deletes the leftovers of a killed one. Thread safety: any thread.
class SealedRows {
 public:
  // `rows` outlives it.
  explicit SealedRows(Transactions& rows);
  ~SealedRows();  // what is left stays for the next start
  SealedRows(const SealedRows&) = delete;
  SealedRows& operator=(const SealedRows&) = delete;

  void Add(const Uuid& attempt);
  // Adds every sealed attempt that still has rows; reads an index entry per attempt with rows.
  Status Find();
  // Deletes all that is known now, without leaving time to others. Errors: the database's.
  Status Finish();

 private:
  // Unless somebody else has deleted the rest of it meanwhile.
  void Forget(const Uuid& attempt);
  void Run(const std::stop_token& stop);
  // Deletes a portion of the attempt's rows; `gone` when none is left.
  Status DeleteSome(const Uuid& attempt, bool& gone);

  Transactions& rows_;
  Mutex mutex_;
  std::condition_variable_any wake_;
  std::deque<Uuid> attempts_ ENAMEL_GUARDED_BY(mutex_);
  std::jthread thread_;  // last: uses the rest
};

}  // namespace enamel::server
