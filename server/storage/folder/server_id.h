#pragma once

#include <filesystem>

#include "common/base/result.h"
#include "common/base/uuid.h"
#include "server/storage/folder/disk.h"

namespace enamel::server {

// server.id in a data folder: tells this server from others that keep their rows in the same
// database. Its leases (schemas/sql/0001_initial.sql) and its chain of the audit trail
// (schemas/audit.md) go by it. A UUID as text and a line's end; no secret. Two folders must not
// have the same: a copied folder is one server twice.
//
// Reads it, or makes it where it is not there. Errors: kStorage, kInvalidInput (it is no UUID).
Result<Uuid> EnsureServerId(const std::filesystem::path& folder, Disk& disk);

}  // namespace enamel::server
