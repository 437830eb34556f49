#pragma once

#include <chrono>
#include <functional>
#include <string>
#include <vector>

#include "common/base/result.h"
#include "common/trace/trace.h"
#include "station/spool/spool.h"

namespace enamel::station {

// Tickets taken in advance, for hours without the server, each locked with its person's PIN.
//
// Neither a password nor a verifier is kept: a ticket is encrypted (XSalsa20-Poly1305, libsodium's
// secretbox) under argon2id(PIN, salt) with 64 MiB and 3 passes, and only the right PIN opens it.
// From the third wrong PIN on there is a wait of 30 s, doubled each time; after the tenth the
// ticket is destroyed. Each try is counted on disk before the PIN is tested.
//
// A ticket that was handed back, expired unused or was destroyed cannot be opened from then on. The
// uploader returns it to the server, so that it no longer counts (Uploader).
//
// Protects against: others at this chair who try PINs to make an attempt in the person's name. Does
// not protect against: somebody who can read the station's disk as its owner. They can try a
// million six-digit PINs elsewhere, at some 0.1 s each, well within the ticket's 12 hours. They
// gain one attempt under that name, on this station only, because its key has to sign it. So exams
// are not begun this way. Thread safety: that of the spool.
class TicketSafe {
 public:
  static constexpr int kFreeTries = 2, kMaxTries = 10;
  static constexpr std::chrono::seconds kFirstWait{30};
  using Clock = std::function<int64_t()>;  // Unix time, ms

  explicit TicketSafe(Spool& spool, Clock clock = {});

  // `names`: the person and exercise shown in the list. Errors: CheckPin's, the spool's.
  Status Put(const trace::Ticket& ticket, LockedTicket names, const std::string& pin);
  // Tickets that can still be used. Hands back expired ones, or deletes them if their attempt was
  // begun.
  Result<std::vector<LockedTicket>> List();
  // Errors: kUnauthenticated (wrong PIN, with the number of tries left), kUnavailable (wait, with
  // the time), kNotFound (no such ticket, or expired).
  Result<trace::Ticket> Open(const Uuid& attempt, const std::string& pin);
  // Permanent. Errors: kConflict (its attempt was begun), kNotFound.
  Status HandBack(const Uuid& attempt);
  Status Remove(const Uuid& attempt) { return spool_.tickets().Remove(attempt); }

 private:
  Spool& spool_;
  const Clock clock_;
};

}  // namespace enamel::station
