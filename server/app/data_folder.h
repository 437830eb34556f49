#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "common/base/result.h"
#include "common/base/sha256.h"
#include "common/trace/trace.h"
#include "server/storage/audit/actor.h"
#include "server/storage/engine/server_identity.h"
#include "server/storage/store.h"

namespace enamel::server::app {

// "enamel-server 0.9.0", for stations and for the manifest of a backup.
std::string SoftwareName();

// What makes a data folder this server and no other; made once, never overwritten. Losing it means
// enrolling every station again.
struct ServerIdentity {
  // Of a school that an installation serves beside its own (school_folder.h): the installation's.
  std::filesystem::path certificate;  // station.crt, what stations know the server by
  std::filesystem::path private_key;  // station.key, mode 0600
  Sha256 fingerprint;                 // of the certificate
  trace::KeyPair ticket_key;          // ticket.key, mode 0600: signs tickets, results, audit rows
};

// Takes the files of another server's identity (station.crt, station.key, ticket.key) from the
// folder `from` into a data folder that has none, before anything makes them. `moving`: the folder
// has the mark of a move (storage/move/move.h). Errors: kConflict (it has others), kNotFound
// (`from` has not all three), kStorage.
Status TakeIdentity(const std::filesystem::path& folder, const std::filesystem::path& from,
                    bool moving = false);
// Creates missing files. Errors: kStorage, kInvalidInput (a file has unexpected content).
Result<ServerIdentity> EnsureIdentity(const std::filesystem::path& folder);
// The same, and compares it with the identity of the other servers of the store's database. Errors
// also: kConflict (another), kNotFound (none here, and the others have one).
Result<ServerIdentity> EnsureMatchingIdentity(const std::filesystem::path& folder,
                                              ServerIdentityRows& identity_rows);

struct PageCertificate {
  std::filesystem::path certificate;  // page.crt
  std::filesystem::path private_key;  // page.key, mode 0600
  Sha256 fingerprint;
};
// A self-signed certificate of the page, made when absent for the first of `host_names`, or
// localhost. Errors: kStorage, kInvalidInput (the name cannot be one of a certificate).
Result<PageCertificate> EnsurePageCertificate(const std::filesystem::path& folder,
                                              const std::vector<std::string>& host_names);

// The store of a folder; creates the folder if it is missing. For demo data and benchmarks.
Result<std::unique_ptr<Store>> OpenOrMake(const std::filesystem::path& folder);

// The store for a command that runs beside a server, or without one. Makes none: a folder that is
// misspelt is not to become one. Errors also: kNotFound (there is none).
Result<std::unique_ptr<Store>> OpenForCommand(const std::filesystem::path& folder);

// The command line in the audit trail.
inline const Actor kCommandLine{{}, "command line"};

}  // namespace enamel::server::app
