#pragma once

#include <filesystem>
#include <functional>
#include <string>

#include "common/base/result.h"

namespace CLI {
class App;
}

// Recordings on this station: 'enamel-station spool list|verify|export|upload|close' and 'upload'.
namespace enamel::station {

struct SpoolCommand {
  std::filesystem::path data;
  std::string server;   // HOST:PORT when it has moved since enrolment; else empty
  std::string attempt;  // id, or "last"
  std::filesystem::path out;
  bool json = false;        // one JSON object on standard output instead of lines
  uint64_t kbit_per_s = 0;  // of the upload at most; 0: no bound
};

Status ListSpool(const SpoolCommand& options);
// Errors: the worst of what was found.
Status VerifySpool(const SpoolCommand& options);
Status ExportFromSpool(const SpoolCommand& options);
// Sends what the server does not have, also what it lost since (it is asked). Errors: kUnavailable
// when it is not reachable and something waits; the worst refusal when it will not have some of it.
Status UploadSpool(const SpoolCommand& options);
// Seals an attempt that was cut off as far as it goes, so that it is uploaded and scored.
Status CloseInSpool(const SpoolCommand& options);

// Adds them to `app`. `options`, whose data folder is the default, lives as long as the parser;
// `finish` gets each command's outcome.
void AddSpoolCommands(CLI::App& app, SpoolCommand& options,
                      const std::function<void(const Status&)>& finish);

}  // namespace enamel::station
