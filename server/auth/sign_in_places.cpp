#include "server/auth/sign_in_places.h"

namespace enamel::server::auth {
namespace {

// No block contains a line end.
std::string NameOf(const std::string& login, const std::string& block) {
  return block + "\n" + login;
}

}  // namespace

std::optional<Turn> SignInPlaces::Take(const std::string& login, const std::string& block) {
  const std::string name = NameOf(login, block);
  MutexLock lock(mutex_);
  if (known_.contains(name) && waiting_[name] < kMostOfLogin) {
    ++waiting_[name];
    return Turn(name, true);
  }
  const auto at = waiting_.find(block);
  const size_t here = at == waiting_.end() ? 0 : at->second;
  if (here >= of_block_ || (here >= kAlways && others_ >= kMost)) return std::nullopt;
  ++waiting_[block];
  ++others_;
  return Turn(block);
}

void SignInPlaces::Leave(const Turn& turn) {
  MutexLock lock(mutex_);
  if (!turn.first) --others_;
  const auto at = waiting_.find(turn.of);
  if (--at->second == 0) waiting_.erase(at);
}

void SignInPlaces::Know(const std::string& login, const std::string& block) {
  MutexLock lock(mutex_);
  // All at once: who signs in next is known again.
  if (known_.size() >= kMostKnown) known_.clear();
  known_.insert(NameOf(login, block));
}

}  // namespace enamel::server::auth
