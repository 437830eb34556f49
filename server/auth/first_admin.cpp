#include "server/auth/first_admin.h"

#include "common/base/hex.h"
#include "server/auth/token.h"

namespace enamel::server::auth {

std::string FirstAdmin::Offer(UnixMs now_ms) {
  const std::string token = ToHex(NewToken());
  MutexLock lock(mutex_);
  offered_ = Offered{TokenHash(AsBytes(token)), now_ms + kGoodMs, false, 0};
  return token;
}

Status FirstAdmin::Take(std::string_view token, UnixMs now_ms) {
  // The same for every reason: a stranger does not learn whether there is a link.
  const Status refused(Code::kForbidden,
                       "this link has expired or was used; start the server again for another, or "
                       "add an admin on the server (enamel-server admin add-person --role admin)",
                       "token");
  const Sha256 hash = TokenHash(AsBytes(token));
  MutexLock lock(mutex_);
  if (!offered_ || offered_->taken || now_ms >= offered_->until_ms) return refused;
  if (offered_->wrong >= kMaxWrong) return refused;
  if (!SameSecret(hash.Hex(), offered_->hash.Hex())) {
    ++offered_->wrong;
    return refused;
  }
  offered_->taken = true;
  return Status::Ok();
}

void FirstAdmin::GiveBack() {
  MutexLock lock(mutex_);
  if (offered_) offered_->taken = false;
}

}  // namespace enamel::server::auth
