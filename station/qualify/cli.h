#pragma once

namespace CLI {
class App;
}

namespace enamel::station::qualify {

// Mounts `qualify` and `fit-damping` on the program's command line. Each subcommand's callback sets
// *exit_code; `app` and `exit_code` outlive the parsing.
void RegisterQualify(CLI::App& app, int* exit_code);

}  // namespace enamel::station::qualify
