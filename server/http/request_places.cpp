#include "server/http/request_places.h"

#include <optional>
#include <utility>

#include "common/base/bytes.h"
#include "server/auth/address_block.h"
#include "server/http/site.h"

namespace enamel::server::http {

RequestPlaces::Place RequestPlaces::Take(const Request& request) {
  std::string name;
  if (const auto cookie = SessionCookie(request)) {
    const std::string hash = HashSha256(AsBytes(*cookie)).Hex();
    MutexLock lock(mutex_);
    const auto at = people_.find(hash);
    if (at != people_.end()) name = at->second;
  }
  const bool known = !name.empty();
  const size_t most = known ? ops::LimitOf(ops::kPersonRequests, limits_) : of_address_;
  if (!known) name = auth::AddressBlock(request.peer);
  {
    MutexLock lock(counts_->mutex);
    size_t& taken = counts_->taken[name];
    if (taken >= most) {
      counts_->refused += known ? 1 : 0;
      return {name, nullptr};
    }
    ++taken;
  }
  // What it points to only says that it is not null.
  std::shared_ptr<void> held{counts_.get(), [counts = counts_, name](void*) {
                               MutexLock lock(counts->mutex);
                               const auto at = counts->taken.find(name);
                               if (--at->second == 0) counts->taken.erase(at);
                             }};
  return {std::move(name), std::move(held)};
}

ops::BudgetUse RequestPlaces::Uses() const {
  ops::BudgetUse out;
  out.kind = &ops::kPersonRequests;
  out.limit = ops::LimitOf(*out.kind, limits_);
  MutexLock lock(counts_->mutex);
  out.refused = counts_->refused;
  for (const auto& [of, taken] : counts_->taken) {
    if (taken <= out.most || !Uuid::Parse(of).ok()) continue;
    out.most = taken;
    out.party = ops::PartyKind::kPerson;
    out.of = of;
  }
  return out;
}

void RequestPlaces::Know(const Request& request, const Uuid& person) {
  const auto cookie = SessionCookie(request);
  if (!cookie) return;
  MutexLock lock(mutex_);
  // All at once: the next request of each is known again.
  if (people_.size() >= kMaxKnown) people_.clear();
  people_[HashSha256(AsBytes(*cookie)).Hex()] = person.Text();
}

}  // namespace enamel::server::http
