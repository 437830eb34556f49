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
// Neither a password nor anything to check one with is kept: a ticket is encrypted
// (XSalsa20-Poly1305, libsodium's secretbox) under argon2id(PIN, salt) with 64 MiB and 3 passes,
// and only the right PIN opens it. From the third wrong PIN on there is a wait, 30 s doubled each
// time; after the tenth the ticket is destroyed. Tries are counted on disk before they are made.
//
// What is handed back, has expired unused or was destroyed opens nothing any more at once; the
// uploader returns it to the server, so that it no longer counts (Uploader).
//
// What that is good for: nobody else at this chair can make an attempt in the person's name by
// trying PINs. What it is not: who can read the station's disk as its owner can also try a million
// six-digit PINs elsewhere, at some 0.1 s each, well within the ticket's 12 hours; what he wins is
// one attempt under that name, on this station only, as its key has to sign it. So exams are not
// begun this way. Thread safety: that of the spool.
class TicketSafe {
 public:
  static constexpr int kFreeTries = 2, kMaxTries = 10;
  static constexpr std::chrono::seconds kFirstWait{30};
  using Clock = std::function<int64_t()>;  // Unix time, ms

  explicit TicketSafe(Spool& spool, Clock clock = {});

  // 6 to 12 digits, neither all the same nor counting up or down. Errors: kInvalidInput.
  static Status CheckPin(const std::string& pin);

  // `names` gives who and what is shown in the list. Errors: CheckPin's, the spool's.
  Status Put(const trace::Ticket& ticket, LockedTicket names, const std::string& pin);
  // Those that can still be used; expired ones are handed back here, or forgotten when they were
  // begun.
  Result<std::vector<LockedTicket>> List();
  // Errors: kUnauthenticated (wrong PIN; says how many tries are left), kUnavailable (wait; says
  // how long), kNotFound (no such ticket, or expired).
  Result<trace::Ticket> Open(const Uuid& attempt, const std::string& pin);
  // For good. Errors: kConflict (its attempt was begun), kNotFound.
  Status HandBack(const Uuid& attempt);
  Status Remove(const Uuid& attempt) { return spool_.tickets().Remove(attempt); }

 private:
  Spool& spool_;
  const Clock clock_;
};

}  // namespace enamel::station
