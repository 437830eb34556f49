#pragma once

#include <string>
#include <string_view>

#include "server/storage/keys/data_key.h"
#include "server/training/types.h"

namespace enamel::server::auth {

// Shows that a login has signed in with this browser lately, so that whoever guesses at its
// password elsewhere does not delay its owner here (OWASP's device cookies). Opens nothing: the
// password is asked for as ever. The server stores nothing for it, so it survives a restart and
// serves all servers of a school. Thread safety: constant, any thread.
//
// The browser keeps, for the last kMaxLogins of them, 56 hex digits each, joined by dots:
//
//   bytes  what
//       4  until when, in seconds since 1970, big endian
//       8  random: the name of this browser for this login
//      16  BLAKE2b of these and the login, under a key derived from the ticket key
class DeviceTokens {
 public:
  static constexpr int64_t kDays = 30;
  static constexpr size_t kMaxLogins = 5;

  explicit DeviceTokens(const DataKey& key) : key_(key) {}

  // The name of the browser for this login, in hex; none: it has not signed in with it, or it is
  // too long ago. `tokens` is what the browser sent, any text.
  std::string NameFor(std::string_view login, std::string_view tokens, UnixMs now_ms) const;
  // What it is to keep now that the login has signed in.
  std::string With(std::string_view login, std::string_view tokens, UnixMs now_ms) const;

 private:
  std::string Token(std::string_view login, int64_t until_s, const std::string& name) const;
  bool IsOf(std::string_view login, std::string_view token, UnixMs now_ms) const;

  const DataKey key_;
};

}  // namespace enamel::server::auth
