#pragma once

#include <string>
#include <vector>

#include "common/base/result.h"
#include "common/base/uuid.h"
#include "server/storage/audit/actor.h"
#include "server/storage/blobs/blobs.h"
#include "server/storage/engine/transactions.h"
#include "server/training/types.h"

namespace enamel::server {

// Device profiles, their reports, and calibrations of devices.
class ProfileRows {
 public:
  ProfileRows(Transactions& rows, Blobs& blobs) : rows_(rows), blobs_(blobs) {}

  // Name, title and content of `row` count: a new version of the profile of this name when the
  // content differs from the newest one.
  Status PutProfile(const ProfileRow& row, const Actor& by);
  Result<std::vector<ProfileRow>> Profiles();  // newest versions, by name
  // Newest first; empty when there is no such profile.
  Result<std::vector<ProfileRow>> ProfileVersions(const std::string& name);
  // About the newest version. The same content again returns the existing row. Errors: kNotFound
  // (the profile, the blob).
  Result<ProfileReportRow> AddProfileReport(const ProfileReportRow& row, const Actor& by);
  Result<std::vector<ProfileReportRow>> ProfileReports(const std::string& profile);
  Result<ProfileReportRow> ProfileReportById(const Uuid& id);
  // The same document again returns the existing row. Errors: kNotFound (the profile).
  Result<CalibrationRow> AddCalibration(const CalibrationRow& row, const Actor& by);
  // Newest measurement first.
  Result<std::vector<CalibrationRow>> Calibrations(const std::string& profile);

 private:
  Transactions& rows_;
  Blobs& blobs_;
};

}  // namespace enamel::server
