#include "common/program/private_memory.h"

#include <sys/prctl.h>

namespace enamel::program {

void KeepMemoryPrivate() {
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
  prctl(PR_SET_DUMPABLE, 0);
#endif
}

}  // namespace enamel::program
