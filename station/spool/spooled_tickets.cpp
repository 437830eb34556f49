#include "station/spool/spooled_tickets.h"

#include <algorithm>

#include "station/spool/spool_file.h"

namespace enamel::station {

// Never replaced: each ticket is for a different attempt.
Status SpooledTickets::Put(const LockedTicket& ticket) {
  MutexLock lock(file_.mutex());
  sql::Query s(
      file_.db(),
      "INSERT INTO tickets (attempt, person, exercise, title, profile, expires_unix_ms, salt,"
      " locked, hands, outline) VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?)");
  s.BindBlob(ticket.attempt.view())
      .BindText(ticket.person)
      .BindText(ticket.exercise)
      .BindText(ticket.title)
      .BindText(ticket.profile)
      .BindInt(ticket.expires_unix_ms)
      .BindBlob(ticket.salt)
      .BindBlob(ticket.locked)
      .BindInt(static_cast<int64_t>(ticket.hands))
      .BindInt(int64_t{ticket.outline});
  return file_.Run(s, "storing a ticket");
}

Result<std::vector<LockedTicket>> SpooledTickets::List() {
  MutexLock lock(file_.mutex());
  sql::Query s(file_.db(),
               "SELECT attempt, person, exercise, title, profile, expires_unix_ms, salt, locked,"
               " wrong_pins, wait_unix_ms, hands, outline FROM tickets ORDER BY attempt");
  std::vector<LockedTicket> out;
  while (s.Next()) {
    LockedTicket t;
    t.attempt = Uuid::FromBytes(s.Blob(0));
    t.person = s.Text(1);
    t.exercise = s.Text(2);
    t.title = s.Text(3);
    t.profile = s.Text(4);
    t.expires_unix_ms = s.Int(5);
    Bytes salt = s.Blob(6);
    // A damaged row may have a salt of another length; no PIN then opens its ticket.
    std::copy_n(salt.begin(), std::min(salt.size(), t.salt.size()), t.salt.begin());
    t.locked = s.Blob(7);
    t.wrong_pins = static_cast<int>(s.Int(8));
    t.wait_unix_ms = s.Int(9);
    t.hands = static_cast<HandsAllowed>(s.Int(10));
    t.outline = s.Int(11) != 0;
    out.push_back(std::move(t));
  }
  if (!s.status().ok()) return file_.Fail("listing tickets");
  return out;
}

Status SpooledTickets::HandBack(const Uuid& attempt) {
  MutexLock lock(file_.mutex());
  sql::Query s(file_.db(),
               // Overwritten instead of deleted: the server still has to learn which ticket it was.
               "UPDATE tickets SET locked = x'', salt = zeroblob(16) WHERE attempt = ?");
  return file_.Run(s.BindBlob(attempt.view()), "handing back a ticket");
}

Result<std::optional<int>> SpooledTickets::CountPinTry(const Uuid& attempt, int64_t now_unix_ms,
                                                       int free_tries, int most,
                                                       int64_t first_wait_ms) {
  MutexLock lock(file_.mutex());
  sql::Query s(
      file_.db(),
      // One statement checks, counts and sets the wait: of two simultaneous tries the second is
      // counted after the first and meets its wait.
      "UPDATE tickets SET wrong_pins = wrong_pins + 1, wait_unix_ms = CASE"
      " WHEN wrong_pins < ?1 THEN 0 ELSE ?2 + (?3 << (wrong_pins - ?1)) END"
      " WHERE wait_unix_ms <= ?2 AND wrong_pins < ?4 AND attempt = ?5"
      " RETURNING wrong_pins");
  s.BindInt(free_tries)
      .BindInt(now_unix_ms)
      .BindInt(first_wait_ms)
      .BindInt(most)
      .BindBlob(attempt.view());
  const bool counted = s.Next();
  if (!s.status().ok()) return file_.Fail("counting a try of a PIN");
  if (!counted) return std::optional<int>();
  // Stepped to its end first: RETURNING gives the row before the change is committed.
  const int tries = static_cast<int>(s.Int(0));
  ENAMEL_RETURN_IF_ERROR(file_.Run(s, "counting a try of a PIN"));
  return std::optional<int>(tries);
}

// The right PIN proves its person: earlier tries were slips.
Status SpooledTickets::ForgetPinTries(const Uuid& attempt) {
  MutexLock lock(file_.mutex());
  sql::Query s(file_.db(), "UPDATE tickets SET wrong_pins = 0, wait_unix_ms = 0 WHERE attempt = ?");
  return file_.Run(s.BindBlob(attempt.view()), "forgetting tries of a PIN");
}

Status SpooledTickets::Remove(const Uuid& attempt) {
  MutexLock lock(file_.mutex());
  sql::Query s(file_.db(), "DELETE FROM tickets WHERE attempt = ?");
  return file_.Run(s.BindBlob(attempt.view()), "removing a ticket");
}

}  // namespace enamel::station
