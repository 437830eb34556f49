#pragma once

#include <filesystem>
#include <string>

#include "common/base/result.h"
#include "station/app/workplace_settings.h"

// Recordings on this station: 'enamel-station spool list|loops|verify|export|upload|close|salvage'
// and 'upload'.
namespace enamel::station {

struct SpoolCommand {
  WorkplaceOptions workplace;
  std::string attempt;  // id, or "last"
  std::filesystem::path out;
  std::string again;           // for upload: id of a refused attempt to send once more
  std::filesystem::path json;  // the facts as JSON; empty: none
};

// For each attempt: why it waits, since when, and when it was last tried.
Status ListSpool(const SpoolCommand& options);
// How the loop of an attempt ran (schemas/loop_facts.md), for each run that ended properly.
Status ShowLoops(const SpoolCommand& options);
// Changes nothing. Errors: the worst finding.
Status VerifySpool(const SpoolCommand& options);
Status ExportFromSpool(const SpoolCommand& options);
// Sends what the server lacks, including anything it has lost. Then deletes what the server has had
// for long enough, as the settings say. Errors: kUnavailable when the server is not reachable and
// something waits; kForbidden while it refuses recordings.
Status UploadSpool(const SpoolCommand& options);
// Saves what can be read of a damaged spool into a new one in the folder `out`.
Status SalvageIntoFolder(const SpoolCommand& options);
// Seals an interrupted attempt where its recording ends, so that it is uploaded and scored.
Status CloseInSpool(const SpoolCommand& options);

}  // namespace enamel::station
