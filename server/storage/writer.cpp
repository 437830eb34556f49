#include "server/storage/writer.h"

namespace enamel::server::sqlite {

Status Writer::Run(const Work& work) {
  Pending mine{&work, {}, false};
  std::unique_lock lock(mutex_);
  queue_.push_back(&mine);
  while (!mine.done) {
    if (leading_) {
      changed_.wait(lock, [&] { return mine.done || !leading_; });
      continue;
    }
    leading_ = true;
    std::vector<Pending*> batch;
    while (!queue_.empty() && batch.size() < kMaxBatch) {
      batch.push_back(queue_.front());
      queue_.pop_front();
    }
    lock.unlock();
    Commit(batch);
    lock.lock();
    for (Pending* pending : batch) pending->done = true;
    leading_ = false;
    changed_.notify_all();
  }
  return mine.status;
}

void Writer::Commit(const std::vector<Pending*>& batch) {
  Status failure = db_->Exec("BEGIN IMMEDIATE");
  for (size_t i = 0; failure.ok() && i < batch.size(); ++i) {
    failure = RunOne(*batch[i]->work, batch[i]->status);
  }
  if (failure.ok()) failure = db_->Exec("COMMIT");
  if (failure.ok()) return;
  db_->Rollback();
  for (Pending* pending : batch) pending->status = failure;
}

Status Writer::RunOne(const Work& work, Status& outcome) {
  ENAMEL_RETURN_IF_ERROR(db_->Exec("SAVEPOINT one"));
  bool keep_anyway = false;
  outcome = work(*db_, keep_anyway);
  if (!outcome.ok() && !keep_anyway) ENAMEL_RETURN_IF_ERROR(db_->Exec("ROLLBACK TO one"));
  return db_->Exec("RELEASE one");
}

}  // namespace enamel::server::sqlite
