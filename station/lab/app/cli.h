#pragma once

namespace CLI {
class App;
}

namespace enamel::station::lab {

// Mounts the lab's commands on a program's command line: qualify, error, bench, explain and
// fit-damping. Each one's callback sets *exit_code; `app` and `exit_code` outlive the parsing.
void RegisterLab(CLI::App& app, int* exit_code);

}  // namespace enamel::station::lab
