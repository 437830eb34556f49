#include "station/spool/spooled_tickets.h"

#include <algorithm>

#include "station/spool/spool_file.h"
#include "station/spool/statement.h"

namespace enamel::station {

Status SpooledTickets::Put(const LockedTicket& ticket) {
  std::lock_guard lock(file_.mutex());
  Statement s(
      file_.handle(),
      "INSERT INTO tickets (attempt, person, exercise, title, profile, expires_unix_ms, salt,"
      " locked) VALUES (?, ?, ?, ?, ?, ?, ?, ?)");
  s.Blob(ticket.attempt.view())
      .Text(ticket.person)
      .Text(ticket.exercise)
      .Text(ticket.title)
      .Text(ticket.profile)
      .Int(ticket.expires_unix_ms)
      .Blob(ticket.salt)
      .Blob(ticket.locked);
  return s.Step() == SQLITE_DONE ? Status::Ok() : file_.Fail("storing a ticket");
}

Result<std::vector<LockedTicket>> SpooledTickets::List() {
  std::lock_guard lock(file_.mutex());
  Statement s(file_.handle(),
              "SELECT attempt, person, exercise, title, profile, expires_unix_ms, salt, locked,"
              " wrong_pins, wait_unix_ms FROM tickets ORDER BY attempt");
  std::vector<LockedTicket> out;
  int rc = 0;
  while ((rc = s.Step()) == SQLITE_ROW) {
    LockedTicket t;
    t.attempt = Uuid::FromBytes(s.BlobAt(0));
    t.person = s.TextAt(1);
    t.exercise = s.TextAt(2);
    t.title = s.TextAt(3);
    t.profile = s.TextAt(4);
    t.expires_unix_ms = s.IntAt(5);
    Bytes salt = s.BlobAt(6);
    // A damaged row may have a salt of another length: then no PIN opens its ticket.
    std::copy_n(salt.begin(), std::min(salt.size(), t.salt.size()), t.salt.begin());
    t.locked = s.BlobAt(7);
    t.wrong_pins = static_cast<int>(s.IntAt(8));
    t.wait_unix_ms = s.IntAt(9);
    out.push_back(std::move(t));
  }
  if (rc != SQLITE_DONE) return file_.Fail("listing tickets");
  return out;
}

Status SpooledTickets::HandBack(const Uuid& attempt) {
  std::lock_guard lock(file_.mutex());
  Statement s(file_.handle(),
              // Overwritten and not deleted: the server has still to be told which ticket it was.
              "UPDATE tickets SET locked = x'', salt = zeroblob(16) WHERE attempt = ?");
  return s.Blob(attempt.view()).Step() == SQLITE_DONE ? Status::Ok()
                                                      : file_.Fail("handing back a ticket");
}

Result<std::optional<int>> SpooledTickets::CountPinTry(const Uuid& attempt, int64_t now_unix_ms,
                                                       int free_tries, int most,
                                                       int64_t first_wait_ms) {
  std::lock_guard lock(file_.mutex());
  Statement s(
      file_.handle(),
      // One statement looks, counts and sets the wait: two programs that try at the same moment are
      // counted one after the other, and the second finds the first one's wait.
      "UPDATE tickets SET wrong_pins = wrong_pins + 1, wait_unix_ms = CASE"
      " WHEN wrong_pins < ?1 THEN 0 ELSE ?2 + (?3 << (wrong_pins - ?1)) END"
      " WHERE wait_unix_ms <= ?2 AND wrong_pins < ?4 AND attempt = ?5"
      " RETURNING wrong_pins");
  s.Int(free_tries).Int(now_unix_ms).Int(first_wait_ms).Int(most).Blob(attempt.view());
  int rc = s.Step();
  if (rc == SQLITE_DONE) return std::optional<int>();
  if (rc != SQLITE_ROW) return file_.Fail("counting a try of a PIN");
  // Stepped to its end before it is believed: RETURNING gives the row before the change is
  // committed.
  int tries = static_cast<int>(s.IntAt(0));
  return s.Step() == SQLITE_DONE ? Result<std::optional<int>>(tries)
                                 : file_.Fail("counting a try of a PIN");
}

Status SpooledTickets::ForgetPinTries(const Uuid& attempt) {
  std::lock_guard lock(file_.mutex());
  Statement s(file_.handle(),
              "UPDATE tickets SET wrong_pins = 0, wait_unix_ms = 0 WHERE attempt = ?");
  return s.Blob(attempt.view()).Step() == SQLITE_DONE ? Status::Ok()
                                                      : file_.Fail("forgetting tries of a PIN");
}

Status SpooledTickets::Remove(const Uuid& attempt) {
  std::lock_guard lock(file_.mutex());
  Statement s(file_.handle(), "DELETE FROM tickets WHERE attempt = ?");
  return s.Blob(attempt.view()).Step() == SQLITE_DONE ? Status::Ok()
                                                      : file_.Fail("removing a ticket");
}

}  // namespace enamel::station
