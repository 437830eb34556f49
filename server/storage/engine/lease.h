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

// Field of a refusal (kUnavailable): another server of this database erases or applies retention
// just now.
inline constexpr char kLeaseHeld[] = "lease";

struct LeaseTimes {
  std::chrono::milliseconds good{30'000}, renewed_every{10'000};
  std::function<void()> on_renewed{};  // on the lease's thread; for tests
};

// A row of the table `leases`, held until this is destroyed: what only one of the servers of a
// database does at a time. A server that dies keeps it for LeaseTimes::good, by the database's
// clock. On a connection of its own, as the writer's is busy for as long as a rewrite takes; a
// thread renews it.
//
// Who could not renew it in time goes on with what it began, beside whoever has taken it: what is
// done under a lease must do no harm done twice.
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
