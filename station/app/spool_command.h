#pragma once

#include <filesystem>
#include <functional>
#include <string>

#include "common/base/result.h"
#include "station/app/workplace_settings.h"

namespace CLI {
class App;
}

// Recordings on this station: 'enamel-station spool list|loops|verify|export|upload|close|salvage'
// and 'upload'.
namespace enamel::station {

struct SpoolCommand {
  WorkplaceOptions workplace;
  std::string attempt;  // id, or "last"
  std::filesystem::path out;
  std::string again;  // of the upload: a refused attempt's id that is tried once more
  bool json = false;  // one JSON object on standard output instead of lines
};

// Says of what waits why, since when, and when it was tried last.
Status ListSpool(const SpoolCommand& options);
// How the loop of an attempt went (schemas/loop_facts.md), for each time it was run to its end.
Status ShowLoops(const SpoolCommand& options);
// Changes nothing. Errors: the worst of what was found.
Status VerifySpool(const SpoolCommand& options);
Status ExportFromSpool(const SpoolCommand& options);
// Sends what the server does not have, also what it lost since (it is asked). Errors: kUnavailable
// when it is not reachable and something waits; kForbidden while it refuses some of what is here.
// Then forgets what the server has had for long, as the settings say.
Status UploadSpool(const SpoolCommand& options);
// Saves what can be read of a damaged spool into a new one in the folder `out`.
Status SalvageIntoFolder(const SpoolCommand& options);
// Seals an attempt that was cut off as far as it goes, so that it is uploaded and scored.
Status CloseInSpool(const SpoolCommand& options);

// Adds them to `app`. `options` and `settings` live as long as the parser; `finish` gets each
// command's outcome.
void AddSpoolCommands(CLI::App& app, SpoolCommand& options, WorkplaceSettings& settings,
                      const std::function<void(const Status&)>& finish);

}  // namespace enamel::station
