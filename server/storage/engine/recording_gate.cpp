#include "server/storage/engine/recording_gate.h"

namespace enamel::server {

// In time stations delete acknowledged recordings, so a damaged file takes no more of them.
Status RecordingGate::Check() {
  if (!rows_.damaged()) return space_.Check();
  return Status(Code::kUnavailable,
                "the server's database is damaged: stop the server, run enamel-server verify, and "
                "restore a backup; recordings wait at the stations");
}

}  // namespace enamel::server
