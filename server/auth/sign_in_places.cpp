#include "server/auth/sign_in_places.h"

namespace enamel::server::auth {
namespace {

// No block contains a line end.
std::string NameOf(const std::string& login, const std::string& block) {
  return block + "\n" + login;
}

void Less(std::map<std::string, size_t>& counts, const std::string& name) {
  const auto at = counts.find(name);
  if (at != counts.end() && --at->second == 0) counts.erase(at);
}

}  // namespace

bool SignInPlaces::Take(const std::string& login, const std::string& block) {
  const std::string name = NameOf(login, block);
  MutexLock lock(mutex_);
  const auto count = [](const auto& counts, const std::string& of) {
    const auto at = counts.find(of);
    return at == counts.end() ? 0 : at->second;
  };
  const size_t here = count(from_, block);
  const size_t free = taken_ < for_unknown_ ? for_unknown_ - taken_ : 0;
  bool may = false;
  if (known_.contains(name) && count(of_, name) < kMostOfLogin) {
    may = taken_ < all_;
  } else if (known_.contains(block)) {
    may = free > 0 && here < (all_ + 1) / 2;
  } else {
    may = here < (free + 1) / 2;
  }
  if (!may) return false;
  ++taken_;
  ++from_[block];
  ++of_[name];
  return true;
}

void SignInPlaces::Leave(const std::string& login, const std::string& block) {
  MutexLock lock(mutex_);
  --taken_;
  Less(from_, block);
  Less(of_, NameOf(login, block));
}

void SignInPlaces::Know(const std::string& login, const std::string& block) {
  MutexLock lock(mutex_);
  // All at once: who signs in next is known again.
  if (known_.size() + 2 > kMostKnown) known_.clear();
  known_.insert(block);
  known_.insert(NameOf(login, block));
}

}  // namespace enamel::server::auth
