#pragma once

#include <string>

namespace enamel::program {

// What --version prints: "enamel-server 0.1.0 (947b608c2ecb)". The commit is the one that was checked out when the
// program was linked, with "-changed" behind it where tracked files differed from it. Sources that are
// no git checkout have none, and the brackets are left out. Packages of one commit compare equal.
std::string VersionText(const std::string& program);

}  // namespace enamel::program
