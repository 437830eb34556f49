#pragma once

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <functional>
#include <list>
#include <map>
#include <memory>
#include <string>

#include "common/base/bytes.h"
#include "common/base/mutex.h"
#include "common/base/result.h"
#include "common/base/sha256.h"

namespace enamel::server::http {

// Large answers in memory once, however many are being sent: whoever asks while another reads the
// same waits for that. What was computed stays for a while, and only kMaxMade are computed at once.
// Thread safety: any thread; calls block.
class SharedBodies {
 public:
  using Body = std::shared_ptr<const std::string>;
  using Read = std::function<Result<Bytes>()>;

  // `patience`: how long Made waits for its turn.
  explicit SharedBodies(std::chrono::milliseconds patience = kPatience) : patience_(patience) {}

  // `read` gives the bytes that `name` is the hash of. After a failure each waiting caller reads them itself.
  Result<Body> Get(const Sha256& name, const Read& read);
  // The same, and it stays for kFor after its last use, among the newest of kKeptBytes. Errors also:
  // kUnavailable when it was not its turn within the patience.
  Result<Body> Made(const Sha256& name, const Read& make);

  static constexpr size_t kKeptBytes = 32u << 20;
  // Making a surface takes a core, and the memory of a whole tooth.
  static constexpr size_t kMaxMade = 2;
  static constexpr std::chrono::seconds kPatience{10};
  static constexpr std::chrono::minutes kFor{5};

 private:
  struct Slot {
    std::weak_ptr<const std::string> body{};
    bool reading = false;
  };
  struct Kept {
    Sha256 name;
    Body body;
    std::chrono::steady_clock::time_point used;
  };
  Result<Bytes> MakeInTurn(const Read& make);
  void Keep(const Sha256& name, const Body& body) ENAMEL_REQUIRES(mutex_);
  void Forget() ENAMEL_REQUIRES(mutex_);

  const std::chrono::milliseconds patience_;
  Mutex mutex_;
  std::condition_variable_any read_, finished_;
  size_t making_ ENAMEL_GUARDED_BY(mutex_) = 0;
  std::map<Sha256, Slot> slots_ ENAMEL_GUARDED_BY(mutex_);
  std::list<Kept> kept_ ENAMEL_GUARDED_BY(mutex_);  // the newest first
  size_t kept_bytes_ ENAMEL_GUARDED_BY(mutex_) = 0;
};

}  // namespace enamel::server::http
