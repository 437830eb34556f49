#pragma once

#include <string>
#include <vector>

#include "common/base/result.h"
#include "server/storage/actor.h"
#include "server/training/types.h"

namespace enamel::server {

// Stations, the codes they enrol with, and the devices that graded work is done with.
// A part of Store (store.h), which says what holds for all parts.
class StationStore {
 public:
  virtual ~StationStore() = default;

  // Stations. A code works once and before it expires.
  virtual Result<Uuid> AddEnrolCode(const Sha256& code_hash, UnixMs expires_ms,
                                    const Actor& by) = 0;
  // Those that can still be used, the one that expires first at the front.
  virtual Result<std::vector<EnrolCodeRow>> OpenEnrolCodes(UnixMs now_ms) = 0;
  // Errors: kNotFound, kConflict (used already).
  virtual Status WithdrawEnrolCode(const Uuid& id, const Actor& by) = 0;
  // Whether such a code was ever given out here.
  virtual Result<bool> IsEnrolCode(const Sha256& code_hash) = 0;
  // With an id: the station as it was enrolled before, under its old id, also where a restore has
  // forgotten it. Errors also: kConflict (that id has another key, or was revoked).
  virtual Result<StationRow> EnrolStation(const Sha256& code_hash, StationRow station,
                                          const Sha256& credential_hash, UnixMs now_ms) = 0;
  virtual Result<StationRow> StationByCredential(const Uuid& id, const Sha256& credential_hash) = 0;
  virtual Result<StationRow> StationById(const Uuid& id) = 0;
  // It connected.
  virtual Status TouchStation(const Uuid& id, const std::string& software, uint32_t core_version,
                              UnixMs now_ms) = 0;
  // Errors: kConflict with field kStale.
  virtual Result<StationRow> RenameStation(const Uuid& id, const std::string& name,
                                           int32_t revision, const Actor& by) = 0;
  // For good: a station that is to come back enrols anew.
  virtual Status RevokeStation(const Uuid& id, const Actor& by) = 0;
  virtual Result<std::vector<StationRow>> Stations() = 0;
  // Ids of those that were revoked; cheap, however many stations there are.
  virtual Result<std::vector<Uuid>> RevokedStations() = 0;

  // By name. What a listed device admits: HandsAllowed::kListed.
  virtual Result<std::vector<ListedDevice>> ListedDevices() = 0;
  // One that is there gets the new title. Errors: kInvalidInput (name or title).
  virtual Status ListDevice(const std::string& name, const std::string& title, const Actor& by) = 0;
  // Errors: kNotFound.
  virtual Status UnlistDevice(const std::string& name, const Actor& by) = 0;
  virtual Result<bool> IsListed(const Hand& hand) = 0;
};

}  // namespace enamel::server
