#pragma once

namespace CLI {
class App;
}

// `enamel-lab reasons`: the sheet on which a dentist reads what a score says of each fault.
namespace enamel::station::lab {

// The command's callback sets *exit_code; `app` and `exit_code` outlive the parsing.
void RegisterReasons(CLI::App& app, int* exit_code);

}  // namespace enamel::station::lab
