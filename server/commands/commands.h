#pragma once

namespace enamel::server::app {

struct CommandGroup;

// Declares every command of enamel-server, in the order of its help.
void DeclareCommands(CommandGroup root);

}  // namespace enamel::server::app
