#pragma once

#include <atomic>
#include <cstddef>
#include <vector>

#include "common/base/result.h"
#include "common/base/uuid.h"
#include "server/storage/audit/actor.h"
#include "server/storage/blobs/blobs.h"
#include "server/storage/engine/rewrite.h"
#include "server/storage/engine/transactions.h"
#include "server/storage/keys/keyring.h"
#include "server/storage/recordings/sealed_rows.h"
#include "server/storage/upkeep/mentions.h"

namespace enamel::server {

// The data removed with a person.
struct ErasureReport {
  size_t attempts = 0, references = 0, blobs = 0;
  // False: copies of erased data may be in unused parts of the database until FinishErasures.
  bool finished = true;
  std::vector<Mentions> mentions{};  // of the name, which stay
};

// Erases people: the key first, then the rows, then the blobs.
class Erasures {
 public:
  Erasures(Transactions& rows, Rewriter& rewriter, Keyring& keyring, Blobs& blobs,
           SealedRows* sealed)
      : rows_(rows), rewriter_(rewriter), keyring_(keyring), blobs_(blobs), sealed_(sealed) {}

  // Brings key ring and database in line: people erased in one are erased in both, after a restore
  // of either and after a crash in between. Leaves the rest to FinishErasures.
  Status Reconcile();
  // Erases a person: key, attempts with everything made from them, sessions, memberships, name. The
  // audit trail keeps the id, which nothing leads to any more, and a tombstone stays, so that the
  // person is erased again after a restore. Scores of others that were compared with a reference
  // cut of this person stay. Idempotent after a failure. Errors: kNotFound; kConflict (the person's
  // attempts are references and `with_references` is not set; the only admin who may sign in);
  // kUnavailable (a backup is running).
  Result<ErasureReport> ErasePerson(const Uuid& person, bool with_references, const Actor& by);
  // Ends what an erasure had to leave (ErasureReport::finished), or a crash; ApplyRetention does it
  // too. Writes wait meanwhile. Nothing to do: nothing. Errors: kUnavailable (a backup is running,
  // or another erasure; somebody reads), kStorage (no room); it is left for the next call.
  Status FinishErasures();

 private:
  // People erased in the key ring or the database, and from now on in both. If the key ring is
  // unreachable, FinishErasures asks again. Errors: those of Keyring but kUnavailable.
  Result<std::vector<Tombstone>> AllErased();
  // Erases those of them that are in the database: it was restored, or an erasure broke off.
  Status EraseAgain();

  std::atomic<bool> due_{false};  // the key ring was away
  Transactions& rows_;
  Rewriter& rewriter_;
  Keyring& keyring_;
  Blobs& blobs_;
  SealedRows* sealed_;
};

}  // namespace enamel::server
