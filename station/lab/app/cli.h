#pragma once

namespace CLI {
class App;
}

namespace enamel::station::lab {

// Registers the lab's commands: qualify, paper, error, bench, explain and fit-damping. Each command's
// callback sets *exit_code; `app` and `exit_code` outlive the parsing.
void RegisterLab(CLI::App& app, int* exit_code);

}  // namespace enamel::station::lab
