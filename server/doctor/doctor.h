#pragma once

#include <string>
#include <vector>

#include "common/program/findings.h"
#include "server/app/serve.h"
#include "server/training/types.h"

namespace enamel::server::app {

// Checks what a server needs, in the order in which it is set up: folder and files, disk, clock,
// database, buckets, certificates, the running server, the way through the proxy, backups. Changes
// nothing, except that it writes an object to each bucket and deletes it again. Waits are bounded by
// seconds each.
std::vector<program::Finding> Examine(const ServeOptions& serve);

// The parts of Examine, in their order.
namespace examined {

using Findings = std::vector<program::Finding>;

void Folder(const ServeOptions& serve, Findings& out);
void Machine(const ServeOptions& serve, Findings& out);
void Database(const ServeOptions& serve, Findings& out);
void Buckets(const ServeOptions& serve, Findings& out);
void Certificates(const ServeOptions& serve, Findings& out);
void Running(const ServeOptions& serve, Findings& out);
void Proxy(const ServeOptions& serve, Findings& out);
void Backups(const ServeOptions& serve, Findings& out);

// Of a certificate: a month's notice is enough to `renew` it.
program::Finding Dates(const std::string& what, UnixMs until_ms, const std::string& renew);

}  // namespace examined

}  // namespace enamel::server::app
