#pragma once

#include "server/commands/command_line.h"

// `verify-result`: a signed result and the files beside it, checked without a data folder.
namespace enamel::server::app {

void DeclareVerifyResult(CommandGroup root);

}  // namespace enamel::server::app
