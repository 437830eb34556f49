#pragma once

#include <filesystem>
#include <string>

#include "common/base/result.h"

namespace enamel::station {

// `enamel-station verify`: everything that can be checked about an exported recording. Was its
// ticket issued by the server, was every chunk signed by the station, do the chunks follow one
// another to the seal, and does the core do every recorded tick again?
struct VerifyOptions {
  std::filesystem::path data, trace, volume, json;
  // Ed25519 public keys: 64 hexadecimal digits, or a file that holds them. Empty: those of the
  // station that `data` belongs to and of its server.
  std::string station_key, server_key;
};
// Prints each check with what was found. Errors: kConflict when one fails, or when the recording is
// cut short or has no seal; kNotFound and kInvalidInput for keys and files.
Status VerifyRecording(const VerifyOptions& options);

}  // namespace enamel::station
