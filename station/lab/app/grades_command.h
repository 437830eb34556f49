#pragma once

namespace CLI {
class App;
}

// `enamel-lab grades` and `operators`: what faults cost and whether skill is told; `hand-signs`: whether
// a motion tells a person from a program.
namespace enamel::station::lab {

// *exit_code is set by the commands' callbacks; `app` and `exit_code` outlive the parsing.
void RegisterGrades(CLI::App& app, int* exit_code);
void RegisterOperators(CLI::App& app, int* exit_code);
void RegisterHandSigns(CLI::App& app, int* exit_code);

}  // namespace enamel::station::lab
