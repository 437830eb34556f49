#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "common/base/bytes.h"
#include "common/base/result.h"
#include "common/base/uuid.h"
#include "common/hands/hand.h"

namespace enamel::station {

class SpoolFile;

// A ticket taken in advance, locked with its person's PIN (station/session/ticket_safe.h).
struct LockedTicket {
  Uuid attempt;
  std::string person, exercise, title, profile;  // for people
  int64_t expires_unix_ms = 0;
  std::array<uint8_t, 16> salt{};
  Bytes locked;  // empty: it opens nothing any more, and the server is yet to be told
  int wrong_pins = 0;
  int64_t wait_unix_ms = 0;  // no PIN is tried before
  HandsAllowed hands = HandsAllowed::kAny;

  bool handed_back() const { return locked.empty(); }
};

// Those of a spool. What is locked and with which PIN is for station/session/ticket_safe.h. Thread
// safety and errors: those of Spool.
class SpooledTickets {
 public:
  explicit SpooledTickets(SpoolFile& file) : file_(file) {}

  Status Put(const LockedTicket& ticket);
  // Those that were handed back too.
  Result<std::vector<LockedTicket>> List();
  // Takes the ticket itself away, for good, and keeps what it was for until Remove. None: nothing
  // changes.
  Status HandBack(const Uuid& attempt);
  // Counts a try of the ticket's PIN and sets the wait before the next: `first_wait_ms`, doubled
  // each time, from the try after `free_tries` on. In one step and durable before the PIN is tried:
  // neither a pulled plug nor tries at the same moment win a further one. Returns how many there
  // were with this one; nothing when it has to wait, was tried `most` times, or is not there.
  Result<std::optional<int>> CountPinTry(const Uuid& attempt, int64_t now_unix_ms, int free_tries,
                                         int most, int64_t first_wait_ms);
  // The PIN was right.
  Status ForgetPinTries(const Uuid& attempt);
  Status Remove(const Uuid& attempt);

 private:
  SpoolFile& file_;
};

}  // namespace enamel::station
