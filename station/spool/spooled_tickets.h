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
  Bytes locked;  // empty: handed back, and the server does not know yet
  int wrong_pins = 0;
  int64_t wait_unix_ms = 0;  // no PIN is tested before this time
  HandsAllowed hands = HandsAllowed::kAny;
  bool outline = false;  // ChairTerms::outline; no signed exam is taken in advance

  bool handed_back() const { return locked.empty(); }
};

// A spool's tickets for later. Their encryption and PINs are in station/session/ticket_safe.h.
// Thread safety and errors: those of Spool.
class SpooledTickets {
 public:
  explicit SpooledTickets(SpoolFile& file) : file_(file) {}

  Status Put(const LockedTicket& ticket);
  // Includes tickets that were handed back.
  Result<std::vector<LockedTicket>> List();
  // Deletes the ticket itself for good, and keeps its description until Remove. Does nothing if
  // there is none.
  Status HandBack(const Uuid& attempt);
  // Counts a try of the ticket's PIN and sets the wait before the next: `first_wait_ms`, doubled
  // each time, from the try after `free_tries` on. One step, durable before the PIN is tested:
  // neither a pulled plug nor simultaneous tries gain a further try. Returns the number of tries
  // including this one; nothing when it has to wait, was tried `most` times, or does not exist.
  Result<std::optional<int>> CountPinTry(const Uuid& attempt, int64_t now_unix_ms, int free_tries,
                                         int most, int64_t first_wait_ms);
  // The PIN was right.
  Status ForgetPinTries(const Uuid& attempt);
  Status Remove(const Uuid& attempt);

 private:
  SpoolFile& file_;
};

}  // namespace enamel::station
