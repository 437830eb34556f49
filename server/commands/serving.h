#pragma once

// What runs until it is stopped (`serve`, `work`), and what is there to try it with (`seed-demo`), on the command
// line (command_line.h).
namespace enamel::server::app {

struct CommandGroup;
void DeclareServe(CommandGroup root);
void DeclareWork(CommandGroup root);
void DeclareSeed(CommandGroup root);

}  // namespace enamel::server::app
