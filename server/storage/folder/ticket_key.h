#pragma once

#include <filesystem>

#include "common/base/result.h"
#include "common/trace/trace.h"
#include "server/storage/folder/disk.h"

namespace enamel::server {

// ticket.key in a data folder: signs tickets, results and rows of the audit trail. 64 bytes, mode
// 0600, in libsodium's form: the public half is the second one.
std::filesystem::path TicketKeyPath(const std::filesystem::path& folder);

// Reads it. Errors: kNotFound, kInvalidInput (it is no key).
Result<trace::KeyPair> ReadTicketKey(const std::filesystem::path& folder);

// Reads it, or creates a missing one. One process at a time. Errors: kStorage, kInvalidInput (the
// file is no key; it is not replaced, because stations hold tickets that only the old key can have
// signed).
Result<trace::KeyPair> EnsureTicketKey(const std::filesystem::path& folder, Disk& disk);

}  // namespace enamel::server
