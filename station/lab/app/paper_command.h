#pragma once

namespace CLI {
class App;
}

// `enamel-lab paper`: every equation, table and figure of Liu et al. 2008 beside ours.
namespace enamel::station::lab {

// The command's callback sets *exit_code; `app` and `exit_code` outlive the parsing.
void RegisterPaper(CLI::App& app, int* exit_code);

}  // namespace enamel::station::lab
