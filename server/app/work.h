#pragma once

#include <filesystem>
#include <optional>

#include "common/base/result.h"
#include "server/jobs/worker.h"

namespace enamel::server::app {

// What `serve` and `work` have in common: results signed with `key`, every job told to the log.
WorkerOptions LoggedJobs(const trace::KeyPair& key, int threads);

struct WorkOptions {
  std::filesystem::path data;
  std::filesystem::path identity;  // of a server (TakeIdentity); empty: the folder's own
  int threads = 1;
};

// Scores what waits, beside the server or beside several with their rows in one database, until
// SIGINT or SIGTERM. Prints one line "ready …". What it was at goes back to the queue; what it
// leaves when it is killed is taken by another after its lease (WorkerOptions::lease_ms). Errors:
// kNotFound (the folder has no ticket key: no server has used it yet), those of OpenStore.
Status Work(const WorkOptions& options);

struct CommandGroup;
// On the command line (command_line.h).
void DeclareWork(CommandGroup root);

}  // namespace enamel::server::app
