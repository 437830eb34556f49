#pragma once

namespace CLI {
class App;
}

// `enamel-lab pictures`: draws the set views of the built-in teeth and exercises and compares them
// with kept pictures.
namespace enamel::station::lab {

// The command's callback sets *exit_code; `app` and `exit_code` outlive the parsing.
void RegisterPictures(CLI::App& app, int* exit_code);

}  // namespace enamel::station::lab
