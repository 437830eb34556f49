#pragma once

namespace CLI {
class App;
}

// `enamel-lab grades` and `operators`: the cost of faults, and whether scores rank skill;
// `hand-signs`: whether a motion distinguishes a person from a program.
namespace enamel::station::lab {

// The commands' callbacks set *exit_code; `app` and `exit_code` outlive the parsing.
void RegisterGrades(CLI::App& app, int* exit_code);
void RegisterOperators(CLI::App& app, int* exit_code);
void RegisterHandSigns(CLI::App& app, int* exit_code);

}  // namespace enamel::station::lab
