#include "common/program/suggestion.h"

#include <algorithm>
#include <vector>

#include "common/program/log.h"

namespace enamel::program {
namespace {

// Optimal string alignment: letters wrong, missing, too many, or two neighbours exchanged.
size_t Distance(const std::string& a, const std::string& b) {
  std::vector<std::vector<size_t>> d(a.size() + 1, std::vector<size_t>(b.size() + 1));
  for (size_t i = 0; i <= a.size(); ++i) d[i][0] = i;
  for (size_t j = 0; j <= b.size(); ++j) d[0][j] = j;
  for (size_t i = 1; i <= a.size(); ++i) {
    for (size_t j = 1; j <= b.size(); ++j) {
      d[i][j] =
          std::min({d[i - 1][j] + 1, d[i][j - 1] + 1, d[i - 1][j - 1] + (a[i - 1] != b[j - 1])});
      const bool exchanged = i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1];
      if (exchanged) d[i][j] = std::min(d[i][j], d[i - 2][j - 2] + 1);
    }
  }
  return d[a.size()][b.size()];
}

std::vector<std::string> NamesIn(const CLI::App& app, bool options) {
  std::vector<std::string> out;
  if (!options) {
    for (const CLI::App* command : app.get_subcommands({})) out.push_back(command->get_name());
    return out;
  }
  for (const CLI::Option* option : app.get_options()) {
    for (const std::string& name : option->get_lnames()) out.push_back("--" + name);
  }
  return out;
}

// The last command that was recognised.
const CLI::App& Deepest(const CLI::App& app) {
  const CLI::App* command = &app;
  while (!command->get_subcommands().empty()) command = command->get_subcommands().back();
  return *command;
}

}  // namespace

std::string UnknownCommand(const CLI::App& app) {
  const std::vector<std::string> words = app.remaining(true);
  if (words.empty() || NamesIn(Deepest(app), false).empty()) return {};
  // Behind an option that is none, a word may be its value.
  return words.front().starts_with("-") ? "" : words.front();
}

std::string Suggestion(const CLI::App& app) {
  const CLI::App& command = Deepest(app);
  for (const std::string& whole : app.remaining(true)) {
    const std::string word = whole.substr(0, whole.find('='));
    // A short word is near to everything.
    const size_t most = word.size() < 3 ? 0 : word.size() < 6 ? 1 : 2;
    size_t least = most + 1;
    std::vector<std::string> nearest;
    for (const std::string& name : NamesIn(command, word.starts_with("-"))) {
      const size_t distance = Distance(word, name);
      if (distance > least) continue;
      if (distance < least) nearest.clear();
      least = distance;
      if (distance <= most) nearest.push_back(name);
    }
    if (nearest.size() == 1) return "did you mean '" + nearest[0] + "'?";
  }
  return {};
}

int EndOfParse(const CLI::App& app, const CLI::ParseError& error, bool json) {
  constexpr int kUsage = 2;
  const bool wrong = error.get_exit_code() != 0;
  const std::string suggestion = wrong ? Suggestion(app) : "";
  if (const std::string word = wrong ? UnknownCommand(app) : ""; !word.empty()) {
    SayError("unknown command '" + word + "'" + (suggestion.empty() ? "" : ": " + suggestion) +
             (json ? "" : "\nRun with --help for the list of commands."));
    return kUsage;
  }
  if (wrong && json) {
    SayError(error.what() + (suggestion.empty() ? "" : "; " + suggestion));
    return kUsage;
  }
  app.exit(error);
  if (!suggestion.empty()) SayError(suggestion);
  return wrong ? kUsage : 0;
}

}  // namespace enamel::program
