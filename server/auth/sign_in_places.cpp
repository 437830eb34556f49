#include "server/auth/sign_in_places.h"

#include <limits>

namespace enamel::server::auth {
namespace {

// No place contains a line end.
std::string NameOf(const std::string& login, const std::string& place) {
  return place + "\n" + login;
}

}  // namespace

std::optional<Turn> SignInPlaces::Take(const std::string& login, const std::string& place,
                                       Line line, bool is_party) {
  const std::string name = NameOf(login, place);
  const std::string& of = is_party ? place : name;
  const size_t threads = is_party ? 1 : std::numeric_limits<size_t>::max();
  MutexLock lock(mutex_);
  const bool known = line == Line::kFirst || known_.contains(name);
  if (known && waiting_[of] < kMaxOfLogin) {
    ++waiting_[of];
    return Turn(of, Line::kFirst, threads);
  }
  const auto at = waiting_.find(place);
  const size_t here = at == waiting_.end() ? 0 : at->second;
  if (here >= of_place_ || (here >= kAlways && others_ >= kMost)) return std::nullopt;
  ++waiting_[place];
  ++others_;
  return Turn(place, known ? Line::kUsual : line, threads);
}

void SignInPlaces::Leave(const Turn& turn) {
  MutexLock lock(mutex_);
  if (turn.line != Line::kFirst) --others_;
  const auto at = waiting_.find(turn.of);
  if (--at->second == 0) waiting_.erase(at);
}

void SignInPlaces::Know(const std::string& login, const std::string& place) {
  MutexLock lock(mutex_);
  // All at once: who signs in next is known again.
  if (known_.size() >= kMaxKnown) known_.clear();
  known_.insert(NameOf(login, place));
}

}  // namespace enamel::server::auth
