#include "server/storage/engine/recording_gate.h"

namespace enamel::server {

// Stations delete in time what was acknowledged: a file that cannot be trusted takes nothing more
// in.
Status RecordingGate::Check() {
  if (!rows_.damaged()) return space_.Check();
  return Status(Code::kUnavailable,
                "the server's database is damaged: stop the server, see what verify says, and "
                "restore a backup; recordings wait at the stations");
}

}  // namespace enamel::server
