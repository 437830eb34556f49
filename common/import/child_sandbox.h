#pragma once

namespace enamel::import {

// Limits of the import child: 60 s of processor time, 4 GiB of memory, no file may be written; it
// ends with the thread that started it.
void LimitResources();

// From here on the process has its memory, its open files, the time and its end (seccomp): it can
// open no file, make no socket, and neither start nor reach another process. Returns false where the kernel does not offer it: then no file may be
// parsed.
[[nodiscard]] bool ForbidSystem();

}  // namespace enamel::import
