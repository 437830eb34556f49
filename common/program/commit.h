#pragma once

namespace enamel::program {

// Written by the build (commit.cmake).
extern const char kVersion[];  // "0.1.0"
extern const char kCommit[];   // "947b608c2ecb"; empty outside a git checkout

}  // namespace enamel::program
