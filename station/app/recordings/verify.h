#pragma once

#include <filesystem>
#include <string>

#include "common/base/result.h"

namespace enamel::station {

// `enamel-station verify` checks an exported recording as far as possible without the server: the
// server issued its ticket, the station signed every chunk, the chunks form a chain to the seal,
// and the core reproduces every tick.
struct VerifyOptions {
  std::filesystem::path data, trace, volume, json;
  // Ed25519 public keys: 64 hexadecimal digits, or a file that holds them. Empty: the keys of the
  // station in `data` and of its server.
  std::string station_key, server_key;
};
// Prints each check and its finding. Errors: kConflict when a check fails, or when the recording is
// cut short or has no seal; kNotFound and kInvalidInput for keys and files.
Status VerifyRecording(const VerifyOptions& options);

}  // namespace enamel::station
