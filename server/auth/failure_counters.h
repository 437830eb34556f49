#pragma once

#include <array>
#include <functional>
#include <string>
#include <unordered_map>

#include "common/base/mutex.h"
#include "server/storage/people/sign_in_rows.h"
#include "server/storage/store.h"

namespace enamel::server::auth {

// What Throttle counts about one try to sign in, and under which names. No name: not counted.
template <typename T>
struct OfTry {
  T here;      // the login at this place: failures, first tries
  T place;     // any login at this place: failures, when the next held try may go on
  T site;      // the same of the AddressSite, where that is more than the place
  T anywhere;  // the login at any place: failures, when the next first try at a place may go on
  T known;     // the login at this place: its last success
};

// Where that is kept. Thread safety: any thread.
class FailureCounters {
 public:
  using Change = std::function<void(OfTry<SignInCounter>&)>;
  virtual ~FailureCounters() = default;
  // Passes the counters of these names to `change` and stores its result, without another change in
  // between. `change` may be called again with newer ones. Errors: the store's.
  virtual Status Apply(const OfTry<std::string>& names, UnixMs now_ms, const Change& change) = 0;
};

// This server's memory: 20 000 counters and as many known places; those that would be forgotten
// first go.
class MemoryCounters final : public FailureCounters {
 public:
  Status Apply(const OfTry<std::string>& names, UnixMs now_ms, const Change& change) override;

 private:
  using Map = std::unordered_map<std::string, SignInCounter>;
  static SignInCounter Read(const Map& map, const std::string& name);
  static void Write(Map& map, const std::string& name, const SignInCounter& counter, UnixMs now_ms);

  Mutex mutex_;
  Map counters_ ENAMEL_GUARDED_BY(mutex_);
  Map known_ ENAMEL_GUARDED_BY(mutex_);
};

// The store's, which other servers count in too. Blocks.
class SharedCounters final : public FailureCounters {
 public:
  explicit SharedCounters(Store& store) : store_(store) {}
  Status Apply(const OfTry<std::string>& names, UnixMs now_ms, const Change& change) override;

 private:
  Store& store_;
};

}  // namespace enamel::server::auth
