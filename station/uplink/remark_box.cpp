#include "station/uplink/remark_box.h"

#include <algorithm>

namespace enamel::station {

void RemarkBox::Begin(const Uuid& attempt) {
  MutexLock lock(mutex_);
  if (attempt == attempt_) return;
  attempt_ = attempt;
  waiting_.clear();
  newest_ = shown_ = 0;
}

void RemarkBox::Arrived(const Uuid& attempt, const protocol::Remark& remark) {
  MutexLock lock(mutex_);
  if (attempt != attempt_ || remark.id <= newest_ || remark.text.empty()) return;
  if (waiting_.size() >= protocol::kMaxRemarks) return;
  newest_ = remark.id;
  waiting_.push_back(remark);
}

std::optional<protocol::Remark> RemarkBox::Next(const Uuid& attempt) const {
  MutexLock lock(mutex_);
  if (attempt != attempt_ || waiting_.empty()) return std::nullopt;
  return waiting_.front();
}

void RemarkBox::Shown(const Uuid& attempt, uint64_t id) {
  MutexLock lock(mutex_);
  if (attempt != attempt_) return;
  shown_ = std::max(shown_, id);
  while (!waiting_.empty() && waiting_.front().id <= shown_) waiting_.pop_front();
}

uint64_t RemarkBox::shown(const Uuid& attempt) const {
  MutexLock lock(mutex_);
  return attempt == attempt_ ? shown_ : 0;
}

}  // namespace enamel::station
