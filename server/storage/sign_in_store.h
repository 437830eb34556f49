#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "common/base/result.h"
#include "common/base/sha256.h"
#include "server/training/types.h"

namespace enamel::server {

// What is counted under one key. As it begins: nothing is.
struct SignInCounter {
  uint32_t failures = 0;
  uint32_t first_tries = 0;
  UnixMs last_ms = 0;
  UnixMs next_try_ms = 0;
  UnixMs until_ms = 0;  // forgotten then
  auto operator<=>(const SignInCounter&) const = default;
};

// Failures to sign in that the servers of a school count together; the rules are auth::Throttle's. A server that is
// the only one (UpkeepStore::IsShared) counts in its own memory.
// A part of Store (store.h), which says what holds for all parts.
class SignInStore {
 public:
  virtual ~SignInStore() = default;

  // Hands the counters of these keys, each its own, to `change` and keeps what it makes of them; nobody
  // else's change comes between. `change` may be called again with newer ones. What it leaves as it was costs no
  // write. At most kMostSignInCounters with failures are kept, and as many without: those that would be forgotten
  // first go.
  static constexpr int64_t kMostSignInCounters = 100'000;
  using SignInChange = std::function<void(std::vector<SignInCounter>&)>;
  virtual Status ChangeSignIns(const std::vector<Sha256>& keys, const SignInChange& change) = 0;
};

}  // namespace enamel::server
