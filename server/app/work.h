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

// Scores queued attempts until SIGINT or SIGTERM, beside one server or several that share a
// database. Prints one line "ready …". An unfinished job goes back to the queue; after a kill,
// another worker takes it once its lease has ended (WorkerOptions::lease_ms). Errors: kNotFound
// (the folder has no ticket key: no server has used it yet), those of OpenStore.
Status Work(const WorkOptions& options);

}  // namespace enamel::server::app
