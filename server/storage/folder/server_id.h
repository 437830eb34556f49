#pragma once

#include <filesystem>

#include "common/base/result.h"
#include "common/base/uuid.h"
#include "server/storage/folder/disk.h"

namespace enamel::server {

// server.id in a data folder distinguishes this server from others that share its database. Its
// leases (schemas/sql/0001_initial.sql) and its chain of the audit trail (schemas/audit.md) use it.
// A UUID as text and a line end; no secret. Two folders must not have the same: a copied folder is
// one server twice.
//
// Reads it, or creates a missing one. Errors: kStorage, kInvalidInput (it is no UUID).
Result<Uuid> EnsureServerId(const std::filesystem::path& folder, Disk& disk);

}  // namespace enamel::server
