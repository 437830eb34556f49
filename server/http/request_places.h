#pragma once

#include <cstddef>
#include <map>
#include <memory>
#include <string>
#include <unordered_map>

#include "common/base/mutex.h"
#include "common/base/sha256.h"
#include "common/base/uuid.h"
#include "server/http/message.h"
#include "server/ops/budgets.h"

namespace enamel::server::http {

// Shares out the requests that may be under way at once, so that nobody takes them all. A person has
// as many as the budget `person_requests` says, which a browser sends at once. Requests whose session is not known here, or that
// have none, share three quarters of all by the block of their address. A request keeps its place
// until its answer has been taken, where that is large. Thread safety: any thread.
class RequestPlaces {
 public:
  // An answer below this does not keep the place while it is being sent.
  static constexpr size_t kLargeBytes = 64 * 1024;

  explicit RequestPlaces(size_t all, const ops::Budgets& limits = {})
      : limits_(limits), of_address_(all - all / 4) {}

  struct Place {
    std::string of;              // the person or the address
    std::shared_ptr<void> held;  // taken until the last copy ends; null: all of theirs are
  };
  Place Take(const Request& request);
  ops::BudgetUse Uses() const;
  // Whose session the request's cookie is.
  void Know(const Request& request, const Uuid& person);

 private:
  static constexpr size_t kMaxKnown = 20'000;
  struct Counts {
    Mutex mutex;
    std::map<std::string, size_t> taken ENAMEL_GUARDED_BY(mutex);
    uint64_t refused ENAMEL_GUARDED_BY(mutex) = 0;  // of people
  };

  const ops::Budgets limits_;
  const size_t of_address_;
  // Places may outlive this.
  const std::shared_ptr<Counts> counts_ = std::make_shared<Counts>();
  Mutex mutex_;
  // By the cookie's hash.
  std::unordered_map<std::string, std::string> people_ ENAMEL_GUARDED_BY(mutex_);
};

}  // namespace enamel::server::http
