#pragma once

#include <string>

#include "common/base/bytes.h"
#include "common/base/result.h"
#include "common/base/uuid.h"
#include "server/storage/audit/actor.h"
#include "server/storage/engine/recording_gate.h"
#include "server/storage/engine/transactions.h"
#include "server/storage/keys/keyring.h"
#include "server/storage/recordings/attempt_keys.h"
#include "server/training/types.h"

namespace enamel::server {

// How an attempt begins: ticket, header, facts.
class TicketRows {
 public:
  TicketRows(Transactions& rows, RecordingGate& gate, Keyring& keyring, AttemptKeys& keys)
      : rows_(rows), gate_(gate), keyring_(keyring), keys_(keys) {}

  // Attempts and their traces. `ticket` is what OpenAttempt's header must contain: one ticket, one
  // attempt, one header. With an assignment: kForbidden when its attempt limit is used up (field
  // "attempt_limit"); as an exam, when the person has another exam attempt that is not sealed
  // (field "exam"); and when another station records an attempt of the person (field "station",
  // kElsewhereMs). None of these where kReadmitted is set. Decided in the transaction, so that two
  // stations cannot both have the last one. Errors also: kNotFound with field "person", "station"
  // or "exercise" (which is not here), kConflict with field "person" (erased).
  Status CreateAttempt(const AttemptRow& row, ByteView ticket, const Actor& by);
  // The attempt's ticket was handed back unused: sets kReturned, and the attempt can no longer be
  // opened. Again: nothing changes. Errors: kNotFound, kConflict (it was opened).
  Status ReturnTicket(const Uuid& attempt, const Actor& by);
  // First or repeated; kConflict when another header is stored, or the ticket was returned;
  // kForbidden with field "sign_off" when a start that must be signed is not. Whether
  // the ticket inside the header is genuine and in time is for the caller to have checked.
  Status OpenAttempt(const Uuid& attempt, ByteView header);
  // AttemptRow::facts from now on. Errors: kNotFound.
  Status KeepFacts(const Uuid& attempt, const std::string& facts);

 private:
  Transactions& rows_;
  RecordingGate& gate_;
  Keyring& keyring_;
  AttemptKeys& keys_;
};

}  // namespace enamel::server
