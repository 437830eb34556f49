#pragma once

namespace enamel::import {

// Limits of the import child: 60 s of processor time, 4 GiB of memory, no file may be written.
void LimitResources();

// From here on the process can open no file, make no socket, start no program and no other process
// (seccomp). Returns false where the kernel does not offer it: then no file may be
// parsed.
[[nodiscard]] bool ForbidSystem();

}  // namespace enamel::import
