#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <stop_token>
#include <string>
#include <thread>

#include "common/base/result.h"
#include "common/base/uuid.h"
#include "common/sql/db.h"

namespace enamel::server {

// Field of a refusal (kUnavailable, LeaseIsHeld): another server of this database makes a backup,
// erases or applies retention just now.
inline constexpr char kLeaseHeld[] = "lease";

Status LeaseIsHeld();

struct LeaseTimes {
  std::chrono::milliseconds good{30'000}, renewed_every{10'000};
  std::function<void()> on_renewed{};  // on the lease's thread; for tests
};

// A row of the table `leases`, held until this is destroyed, for work that only one of a database's
// servers does at a time. A server that dies keeps it for LeaseTimes::good, by the database's
// clock. It uses a connection of its own, because a rewrite keeps the writer busy; a thread renews
// it.
//
// A holder that could not renew it in time continues its work beside the next holder. Work under a
// lease must therefore do no harm when done twice.
class Lease {
 public:
  // Errors: kUnavailable, field kLeaseHeld (another has it); the database's.
  static Result<std::unique_ptr<Lease>> Take(std::unique_ptr<sql::Db> db, std::string name,
                                             LeaseTimes times = {});
  ~Lease();
  Lease(const Lease&) = delete;
  Lease& operator=(const Lease&) = delete;

 private:
  Lease(std::unique_ptr<sql::Db> db, std::string name, LeaseTimes times);
  Status Acquire();
  Status Renew();
  void KeepUp(const std::stop_token& stop);

  const std::unique_ptr<sql::Db> db_;  // the thread's, once it runs
  const std::string name_;
  const LeaseTimes times_;
  const Uuid lease_ = Uuid::New();
  std::jthread thread_;
};

}  // namespace enamel::server
