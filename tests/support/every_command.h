#pragma once

#include <gtest/gtest.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

// Checks what the help of each command of a program shows.
namespace enamel::test {

inline std::string WordsOf(const CLI::App& command) {
  const CLI::App* parent = command.get_parent();
  return (parent == nullptr ? "" : WordsOf(*parent) + " ") + command.get_name();
}

inline std::vector<CLI::App*> SelfAndBelow(CLI::App& app) {
  std::vector<CLI::App*> out{&app};
  for (CLI::App* command : app.get_subcommands([](CLI::App*) { return true; })) {
    for (CLI::App* each : SelfAndBelow(*command)) out.push_back(each);
  }
  return out;
}

// The program's command lines in a help's end, without the program's name and what a shell does
// with them: each in an indented line, continued after a backslash.
inline std::vector<std::string> ExamplesIn(const std::string& footer, const std::string& program) {
  std::string joined = footer;
  for (size_t at = 0; (at = joined.find("\\\n", at)) != std::string::npos;) joined.erase(at, 2);
  std::vector<std::string> out;
  std::istringstream lines(joined);
  for (std::string line; std::getline(lines, line);) {
    const size_t at = line.rfind(" " + program + " ");
    if (!line.starts_with("  ") || at == std::string::npos) continue;
    std::string arguments = line.substr(at + program.size() + 2);
    for (const char* end : {" #", " |", " >", " &&"}) {
      arguments = arguments.substr(0, arguments.find(end));
    }
    out.push_back(arguments);
  }
  return out;
}

// Thrown once a command line is known to be right, before its command would run.
struct Parsed {};

// Files that an example names need not be there.
inline void Disarm(CLI::App& app) {
  app.parse_complete_callback([] { throw Parsed(); });
  for (CLI::App* command : SelfAndBelow(app)) {
    for (CLI::Option* option : command->get_options()) {
      try {
        for (int i = 0;; ++i) {
          CLI::Validator* check = option->get_validator(i);
          if (check->get_description() == "FILE") check->active(false);
        }
      } catch (const CLI::OptionNotFound&) {
      }
    }
  }
}

// Fails for a command without an example in its help, for an example that the program refuses, and
// for an option without a description. Call it before anything is parsed.
inline void ExpectHelpOfEveryCommand(CLI::App& app) {
  Disarm(app);
  for (CLI::App* command : SelfAndBelow(app)) {
    bool has_example = false;
    for (const std::string& example : ExamplesIn(command->get_footer(), app.get_name())) {
      try {
        app.parse(example);
      } catch (const Parsed&) {
      } catch (const CLI::ParseError& error) {
        ADD_FAILURE() << WordsOf(*command) << " --help: \"" << example << "\": " << error.what();
        continue;
      }
      // The example is of the command itself, or of one in its group.
      const CLI::App* parsed = &app;
      while (parsed != command && !parsed->get_subcommands().empty()) {
        parsed = parsed->get_subcommands().front();
      }
      has_example = has_example || parsed == command;
    }
    EXPECT_TRUE(has_example) << WordsOf(*command) << " --help has no example of it";
    for (const CLI::Option* option : command->get_options()) {
      const bool is_hidden = option->get_group().empty();
      EXPECT_TRUE(is_hidden || !option->get_description().empty())
          << WordsOf(*command) << ": " << option->get_name() << " has no description";
    }
  }
}

// The guides and the rooms' own texts; the changelog lists what came, not how to use it.
inline std::string AllMarkdown(const std::filesystem::path& root) {
  std::ostringstream out;
  const auto take = [&](const std::filesystem::path& file) {
    if (file.extension() == ".md" && file.filename() != "CHANGELOG.md") {
      out << std::ifstream(file).rdbuf() << '\n';
    }
  };
  for (const auto& each : std::filesystem::directory_iterator(root)) take(each.path());
  for (const char* folder : {"common", "docs", "schemas", "server", "station", "tests"}) {
    for (const auto& each : std::filesystem::recursive_directory_iterator(root / folder)) {
      take(each.path());
    }
  }
  return out.str();
}

// On a command line (--keep-days), as a setting (keep-days = 30), or in a table of settings
// (| `keep-days` |; a key of the section [budgets] has no "budgets-" and may have "_").
inline bool Names(const std::string& markdown, std::string option) {
  const auto is_part = [](char c) {
    return std::isalnum(static_cast<unsigned char>(c)) || c == '-';
  };
  for (size_t at = 0; (at = markdown.find(option, at)) != std::string::npos; ++at) {
    if (!is_part(markdown[at + option.size()]) && (at == 0 || !is_part(markdown[at - 1])))
      return true;
  }
  std::string key = option.substr(2);
  if (markdown.find("\n" + key + " = ") != std::string::npos ||
      markdown.find("`" + key + " = ") != std::string::npos) {
    return true;
  }
  if (key.starts_with("budgets-")) {
    key = key.substr(8);
    std::replace(key.begin(), key.end(), '-', '_');
  }
  return markdown.find("| `" + key + "`") != std::string::npos;
}

// Fails for an option that no Markdown of the repository names.
inline void ExpectEveryOptionIsNamed(CLI::App& app, const std::string& markdown) {
  for (CLI::App* command : SelfAndBelow(app)) {
    for (const CLI::Option* option : command->get_options()) {
      for (const std::string& name : option->get_lnames()) {
        EXPECT_TRUE(option->get_group().empty() || Names(markdown, "--" + name))
            << WordsOf(*command) << " --" << name
            << ": no Markdown names it. Name it where a user needs it, or delete it";
      }
    }
  }
}

}  // namespace enamel::test
