#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "common/base/mutex.h"
#include "common/base/result.h"
#include "common/base/sha256.h"
#include "server/training/types.h"

namespace enamel::server::auth {

// A link with which the first admin of a new server makes the own account. Kept in memory alone,
// and as a hash: a server that starts again without an admin offers another, and none is in a
// backup.
//
// Good once, for kGoodMs, and no longer after kMaxWrong wrong tokens (256 random bits are not
// guessed; who tries is noticed). Thread safety: any thread.
class FirstAdmin {
 public:
  static constexpr UnixMs kGoodMs = 24ll * 60 * 60 * 1000;
  static constexpr uint32_t kMaxWrong = 100;

  // The token, 64 hexadecimal digits; one that was offered before is void.
  std::string Offer(UnixMs now_ms);
  // From now on nobody else can use it. Errors: kForbidden, field "token" (none is offered, it ran
  // out, was used, or is another).
  Status Take(std::string_view token, UnixMs now_ms);
  // The taken offer made no account: it is valid again.
  void GiveBack();

 private:
  struct Offered {
    Sha256 hash;
    UnixMs until_ms = 0;
    bool taken = false;
    uint32_t wrong = 0;
  };
  Mutex mutex_;
  std::optional<Offered> offered_ ENAMEL_GUARDED_BY(mutex_);
};

}  // namespace enamel::server::auth
