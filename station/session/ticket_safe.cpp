#include "station/session/ticket_safe.h"

#include <sodium.h>

#include <algorithm>

#include "common/base/counted.h"
#include "common/base/pin.h"
#include "common/base/unix_time.h"

namespace enamel::station {
namespace {

// A PIN of six digits has 20 bits: the work for each guess protects a stolen spool file. Argon2id
// with 64 MiB and one pass more than libsodium's "interactive" work. At 0.1 s each, all PINs of six
// digits take a processor a day, and a ticket lasts 12 hours.
constexpr unsigned long long kPasses = 3;
constexpr size_t kMemoryBytes = size_t{64} << 20;

static_assert(crypto_pwhash_SALTBYTES == sizeof(LockedTicket::salt));

using Key = std::array<uint8_t, crypto_secretbox_KEYBYTES>;

Result<Key> KeyOf(const std::string& pin, const std::array<uint8_t, 16>& salt) {
  // Each time: it does nothing after the first, and callers need not know of it.
  ENAMEL_CHECK(sodium_init() >= 0);
  Key key{};
  if (crypto_pwhash(key.data(), key.size(), pin.data(), pin.size(), salt.data(), kPasses,
                    kMemoryBytes, crypto_pwhash_ALG_ARGON2ID13) != 0) {
    return Status(Code::kInternal, "not enough memory to check the PIN (it takes 64 MiB)");
  }
  return key;
}

Status NoTicket(const Uuid& attempt) {
  return Status(Code::kNotFound,
                "no ticket for later " + attempt.Text() +
                    " is here: it was used or given back, has expired (after 12 hours), was "
                    "revoked, or its PIN was wrong too often");
}

}  // namespace

TicketSafe::TicketSafe(Spool& spool, Clock clock)
    : spool_(spool), clock_(clock ? std::move(clock) : [] { return UnixMs(); }) {}

Status TicketSafe::Put(const trace::Ticket& ticket, LockedTicket names, const std::string& pin) {
  ENAMEL_RETURN_IF_ERROR(CheckPin(pin));
  names.attempt = ticket.attempt;
  names.expires_unix_ms = ticket.expires_unix_ms;
  randombytes_buf(names.salt.data(), names.salt.size());
  ENAMEL_ASSIGN_OR_RETURN(auto key, KeyOf(pin, names.salt));
  Bytes open = trace::EncodeTicket(ticket);
  names.locked.resize(crypto_secretbox_NONCEBYTES + crypto_secretbox_MACBYTES + open.size());
  // Key and nonce are both new for each ticket, the key by its salt, so no nonce is ever used
  // twice.
  randombytes_buf(names.locked.data(), crypto_secretbox_NONCEBYTES);
  crypto_secretbox_easy(names.locked.data() + crypto_secretbox_NONCEBYTES, open.data(), open.size(),
                        names.locked.data(), key.data());
  // The compiler might omit a plain assignment, as nothing reads the key any more.
  sodium_memzero(key.data(), key.size());
  return spool_.tickets().Put(names);
}

Result<std::vector<LockedTicket>> TicketSafe::List() {
  auto all = spool_.tickets().List();
  ENAMEL_RETURN_IF_ERROR(all.status());
  std::erase_if(*all, [](const LockedTicket& t) { return t.handed_back(); });
  for (const LockedTicket& t : *all) {
    if (t.expires_unix_ms > clock_()) continue;
    // If its attempt was begun there is nothing to give back: the server will see the recording.
    bool begun = spool_.Get(t.attempt).ok();
    ENAMEL_RETURN_IF_ERROR(begun ? spool_.tickets().Remove(t.attempt)
                                 : spool_.tickets().HandBack(t.attempt));
  }
  std::erase_if(*all, [&](const LockedTicket& t) { return t.expires_unix_ms <= clock_(); });
  return all;
}

Status TicketSafe::HandBack(const Uuid& attempt) {
  ENAMEL_ASSIGN_OR_RETURN(auto all, List());
  if (std::ranges::find(all, attempt, &LockedTicket::attempt) == all.end()) {
    return NoTicket(attempt);
  }
  if (spool_.Get(attempt).ok()) {
    return Status(Code::kConflict, "attempt " + attempt.Text() +
                                       " was begun, so its ticket is used up: resume the attempt, "
                                       "or end it where it stopped");
  }
  return spool_.tickets().HandBack(attempt);
}

Result<trace::Ticket> TicketSafe::Open(const Uuid& attempt, const std::string& pin) {
  ENAMEL_ASSIGN_OR_RETURN(auto all, List());
  auto t = std::ranges::find(all, attempt, &LockedTicket::attempt);
  if (t == all.end()) return NoTicket(attempt);
  if (int64_t wait_ms = t->wait_unix_ms - clock_(); wait_ms > 0) {
    return Status(Code::kUnavailable, "after a wrong PIN: wait " +
                                          std::to_string((wait_ms + 999) / 1000) +
                                          " s before the next try");
  }
  // Counted before testing: pulling the plug after a wrong PIN does not regain the try.
  ENAMEL_ASSIGN_OR_RETURN(
      auto counted, spool_.tickets().CountPinTry(attempt, clock_(), kFreeTries, kMaxTries,
                                                 std::chrono::milliseconds(kFirstWait).count()));
  if (!counted) return Status(Code::kUnavailable, "another try of this PIN is running: wait");
  const int tries = *counted;
  ENAMEL_ASSIGN_OR_RETURN(auto key, KeyOf(pin, t->salt));
  const size_t overhead = crypto_secretbox_NONCEBYTES + crypto_secretbox_MACBYTES;
  Bytes open(t->locked.size() > overhead ? t->locked.size() - overhead : 0);
  bool right = !open.empty() && crypto_secretbox_open_easy(
                                    open.data(), t->locked.data() + crypto_secretbox_NONCEBYTES,
                                    t->locked.size() - crypto_secretbox_NONCEBYTES,
                                    t->locked.data(), key.data()) == 0;
  sodium_memzero(key.data(), key.size());
  // Only the authentication code shows whether the PIN was right.
  if (right) {
    ENAMEL_RETURN_IF_ERROR(spool_.tickets().ForgetPinTries(attempt));
    return trace::DecodeTicket(open);
  }
  if (tries < kMaxTries) {
    return Status(Code::kUnauthenticated,
                  "wrong PIN; " + Counted(kMaxTries - tries, "more try", "more tries"), "pin");
  }
  bool begun = spool_.Get(attempt).ok();
  ENAMEL_RETURN_IF_ERROR(begun ? spool_.tickets().Remove(attempt)
                               : spool_.tickets().HandBack(attempt));
  return Status(Code::kUnauthenticated,
                "wrong PIN for the tenth time: the ticket is destroyed; get another one from the "
                "server",
                "pin");
}

}  // namespace enamel::station
