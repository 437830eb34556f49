#include "server/storage/recordings/sealed_rows.h"

#include <chrono>

#include "server/storage/engine/query.h"

namespace enamel::server {
namespace {

// An arriving chunk waits for one portion at most.
constexpr int64_t kPortion = 128;
constexpr std::chrono::milliseconds kAfterFailure{1000};
// Of the time that portions take, to others.
constexpr int kShareOfOthers = 2;

}  // namespace

SealedRows::SealedRows(Transactions& rows)
    : rows_(rows), thread_([this](const std::stop_token& stop) { Run(stop); }) {}

SealedRows::~SealedRows() = default;

void SealedRows::Add(const Uuid& attempt) {
  {
    MutexLock lock(mutex_);
    attempts_.push_back(attempt);
  }
  wake_.notify_one();
}

Status SealedRows::Find() {
  return rows_.Read([this](Db& db) -> Status {
    // From one attempt's rows to the next one's along the index, not row by row.
    Query q(
        db,
        "WITH RECURSIVE found(attempt) AS (SELECT (SELECT attempt FROM trace_chunks WHERE tenant = "
        "?1 ORDER BY attempt LIMIT 1) UNION ALL SELECT (SELECT attempt FROM trace_chunks WHERE "
        "tenant = ?1 AND attempt "
        "> found.attempt ORDER BY attempt LIMIT 1) FROM found WHERE found.attempt IS NOT NULL) "
        "SELECT id FROM found JOIN attempts ON tenant = ?1 AND id = found.attempt "
        "WHERE trace_blob IS NOT NULL");
    while (q.Next()) Add(q.Id(0));
    return q.status();
  });
}

void SealedRows::Forget(const Uuid& attempt) {
  MutexLock lock(mutex_);
  if (!attempts_.empty() && attempts_.front() == attempt) attempts_.pop_front();
}

Status SealedRows::Finish() {
  for (;;) {
    Uuid attempt;
    {
      MutexLock lock(mutex_);
      if (attempts_.empty()) return Status::Ok();
      attempt = attempts_.front();
    }
    bool gone = false;
    ENAMEL_RETURN_IF_ERROR(DeleteSome(attempt, gone));
    if (gone) Forget(attempt);
  }
}

void SealedRows::Run(const std::stop_token& stop) {
  mutex_.lock();
  while (wake_.wait(mutex_, stop, [&]() ENAMEL_REQUIRES(mutex_) { return !attempts_.empty(); })) {
    const Uuid attempt = attempts_.front();
    mutex_.unlock();
    const auto begin = std::chrono::steady_clock::now();
    bool gone = false;
    Status deleted = DeleteSome(attempt, gone);
    const auto took = std::chrono::steady_clock::now() - begin;
    // Left at the front after a failure: it is tried again, and after a restart Find finds it.
    if (deleted.ok() && gone) Forget(attempt);
    const auto pause = deleted.ok() ? kShareOfOthers * took : kAfterFailure;
    mutex_.lock();
    wake_.wait_for(mutex_, stop, pause, [] { return false; });
    if (stop.stop_requested()) break;
  }
  mutex_.unlock();
}

Status SealedRows::DeleteSome(const Uuid& attempt, bool& gone) {
  return rows_.Write([&](Db& db) -> Status {
    Query q(
        db,
        "DELETE FROM trace_chunks WHERE tenant = ?1 AND attempt = ?2 AND seq IN (SELECT seq "
        "FROM trace_chunks WHERE tenant = ?1 AND attempt = ?2 ORDER BY seq LIMIT ?3) AND EXISTS "
        "(SELECT 1 FROM attempts WHERE tenant = ?1 AND id = ?2 AND trace_blob IS NOT NULL)");
    ENAMEL_RETURN_IF_ERROR(q.Bind(attempt, kPortion).Run());
    gone = db.Changes() < kPortion;
    return Status::Ok();
  });
}

}  // namespace enamel::server
