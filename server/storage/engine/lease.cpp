#include "server/storage/engine/lease.h"

#include <spdlog/spdlog.h>

#include <utility>

#include "common/base/stoppable_sleep.h"
#include "server/storage/engine/query.h"

namespace enamel::server {

Status LeaseIsHeld() {
  return Status(Code::kUnavailable,
                "another server of this school makes a backup, or removes erased or expired data; "
                "try again when that is done",
                kLeaseHeld);
}

Result<std::unique_ptr<Lease>> Lease::Take(std::unique_ptr<sql::Db> db, std::string name,
                                           LeaseTimes times) {
  std::unique_ptr<Lease> out(new Lease(std::move(db), std::move(name), times));
  ENAMEL_RETURN_IF_ERROR(out->Acquire());
  out->thread_ =
      std::jthread([lease = out.get()](const std::stop_token& stop) { lease->KeepUp(stop); });
  return out;
}

Lease::Lease(std::unique_ptr<sql::Db> db, std::string name, LeaseTimes times)
    : db_(std::move(db)), name_(std::move(name)), times_(times) {}

Lease::~Lease() {
  if (!thread_.joinable()) return;
  thread_.request_stop();
  thread_.join();
  Query q(*db_, "DELETE FROM leases WHERE tenant = ?1 AND name = ?2 AND lease = ?3");
  const Status given_back = q.Bind(name_, lease_).Run();
  if (!given_back.ok()) {
    spdlog::warn("the lease \"{}\" ends by itself in {} s: {}", name_, times_.good.count() / 1000,
                 given_back.message());
  }
}

Status Lease::Acquire() {
  Query q(*db_,
          "INSERT INTO leases (tenant, name, lease, until_ms) VALUES (?1, ?2, ?3, ?4) ON CONFLICT "
          "(tenant, name) DO UPDATE SET lease = ?3, until_ms = ?4 WHERE leases.until_ms < ?5");
  const int64_t now_ms = NowMs();
  ENAMEL_RETURN_IF_ERROR(q.Bind(name_, lease_, now_ms + times_.good.count(), now_ms).Run());
  if (db_->Changes() > 0) return Status::Ok();
  return LeaseIsHeld();
}

Status Lease::Renew() {
  Query q(*db_, "UPDATE leases SET until_ms = ?4 WHERE tenant = ?1 AND name = ?2 AND lease = ?3");
  return q.Bind(name_, lease_, NowMs() + times_.good.count()).Run();
}

void Lease::KeepUp(const std::stop_token& stop) {
  while (!SleepUntilStopped(stop, times_.renewed_every)) {
    // What fails is in the log. It is tried again in time, or the lease ends.
    if (Renew().ok() && times_.on_renewed) times_.on_renewed();
  }
}

}  // namespace enamel::server
