#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <string_view>

#include "common/base/result.h"
#include "common/base/sha256.h"
#include "common/base/uuid.h"
#include "common/net/frame_client.h"
#include "common/trace/trace.h"

namespace enamel::station {

// What a station received on enrolment, and the key that signs its recordings.
struct Credentials {
  net::Endpoint server;
  Sha256 fingerprint;  // of the server's certificate
  Uuid station;
  std::array<uint8_t, 32> credential{};
  std::string name;
  trace::PublicKey ticket_key{};  // the server's, for tickets
  trace::SecretKey secret_key{};  // the station's

  trace::PublicKey public_key() const;
};

// `folder`/station.json, readable by its owner only: the students' account must not be this one.
// Errors of Load: kNotFound (not enrolled: message says how); with field kEnrolment kInvalidInput,
// kVersion, kForbidden when others may read the file, or those of reading it.
inline constexpr char kEnrolment[] = "enrolment";
Status SaveCredentials(const std::filesystem::path& folder, const Credentials& credentials);
Result<Credentials> LoadCredentials(const std::filesystem::path& folder);
// The same station when the server has moved to another address (HOST:PORT; empty: as enrolled).
// The server's identity stays pinned: another server at that address is refused. Errors also:
// kInvalidInput with field kServerOption for an invalid address.
inline constexpr char kServerOption[] = "server";
Result<Credentials> LoadCredentialsFor(const std::filesystem::path& folder,
                                       std::string_view server);

// A one-time code as `enamel-server admin enrol-code` prints it: CODE@FINGERPRINT, the fingerprint
// as 64 hexadecimal digits, with or without colons. Errors: kInvalidInput.
struct EnrolCode {
  std::string code;
  Sha256 fingerprint;
};
Result<EnrolCode> ParseEnrolCode(std::string_view text);
// The code of the station with this name in a table as `enamel-server admin enrol-code --names`
// prints it (schemas/enrolment_codes.md). Errors: kNotFound, kInvalidInput.
Result<EnrolCode> FindEnrolCode(std::string_view table, std::string_view name);

}  // namespace enamel::station
