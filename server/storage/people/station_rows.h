#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/base/result.h"
#include "common/base/sha256.h"
#include "common/base/uuid.h"
#include "server/storage/audit/actor.h"
#include "server/storage/engine/transactions.h"
#include "server/training/types.h"

namespace enamel::server {

// Stations and the codes they enrol with.
class StationRows {
 public:
  explicit StationRows(Transactions& rows) : rows_(rows) {}

  // Stations. A code works once and before it expires.
  Result<Uuid> AddEnrolCode(const Sha256& code_hash, UnixMs expires_ms, const Actor& by);
  // Those that can still be used, the one that expires first at the front.
  Result<std::vector<EnrolCodeRow>> OpenEnrolCodes(UnixMs now_ms);
  // Errors: kNotFound, kConflict (used already).
  Status WithdrawEnrolCode(const Uuid& id, const Actor& by);
  // Whether such a code was ever given out here.
  Result<bool> IsEnrolCode(const Sha256& code_hash);
  // With an id: the station that was enrolled before, under its old id, even if a restore has
  // forgotten it. Errors also: kConflict (that id has another key, or was revoked).
  Result<StationRow> EnrolStation(const Sha256& code_hash, StationRow station,
                                  const Sha256& credential_hash, UnixMs now_ms);
  Result<StationRow> StationByCredential(const Uuid& id, const Sha256& credential_hash);
  Result<StationRow> StationById(const Uuid& id);
  // It connected.
  Status TouchStation(const Uuid& id, const std::string& software, uint32_t core_version,
                      UnixMs now_ms);
  // Errors: kConflict with field kStale, or with field "name" (another station has it).
  Result<StationRow> RenameStation(const Uuid& id, const std::string& name, int32_t revision,
                                   const Actor& by);
  // Permanent: a station that is to come back enrols again.
  Status RevokeStation(const Uuid& id, const Actor& by);
  Result<std::vector<StationRow>> Stations();
  // Ids of those that were revoked; cheap, however many stations there are.
  Result<std::vector<Uuid>> RevokedStations();

 private:
  Transactions& rows_;
};

}  // namespace enamel::server
