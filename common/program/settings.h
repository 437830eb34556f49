#pragma once

#include <filesystem>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/result.h"

namespace CLI {
class App;
}

// Settings from three places, the nearer one wins: command line, environment, file.
namespace enamel::program {

// The environment variable of an option: "--job-threads" is ENAMEL_JOB_THREADS.
std::string EnvironmentName(const std::string& option, const std::string& prefix = "ENAMEL_");

// Gives the options of `command` that the command line did not give the values of their environment
// variables. After the command line was parsed, so that a command only minds its own. Errors:
// kInvalidInput with the variable's name.
Status ReadEnvironment(CLI::App& command, const std::string& prefix = "ENAMEL_");

// Gives the options of `command` that neither command line nor environment gave the values of a
// TOML file (https://toml.io, 1.0). Its keys are the options' long names without dashes in front,
// "job-threads" or "job_threads"; its values are texts, integers, booleans, and lists of texts for
// options that may be repeated. An option in a group belongs to the section of that name:
// "budgets-views" in the group "budgets" is the key "views" of [budgets]. Call it after the command line was parsed. Errors: kNotFound;
// kInvalidInput with line and column, also for a key that is no option (the message lists the
// options) and for a value that the option refuses. A file may serve several commands: keys in
// `of_others` are ignored, and if it holds kAnyKey, all keys that the command does not have are
// ignored: the file is another program's too.
inline constexpr char kAnyKey[] = "*";
Status ReadSettingsFile(const std::filesystem::path& file, CLI::App& command,
                        const std::set<std::string>& of_others = {});

// The same of a file's text; `file` is its name in messages.
Status ReadSettings(std::string_view text, const std::string& file, CLI::App& command,
                    const std::set<std::string>& of_others = {});

// A setting from elsewhere than this computer, its value as text.
struct PolicySetting {
  std::string name, value;
  bool fixed = false;  // before the settings file
};

// Gives the options of `command` the values of a policy, after the file was read. One that is fixed goes
// before the file, any other behind it; none before `nearer`, the settings of command line and
// environment. Returns what is wrong: a value that its option refuses, which then stays as it was.
std::vector<std::string> ApplyPolicy(const std::vector<PolicySetting>& policy, CLI::App& command,
                                     const std::set<std::string>& nearer);

// The settings that the options of `command` were given so far.
std::set<std::string> GivenSettings(const CLI::App& command);
// Those of a settings file, as ReadSettingsFile names them. Empty if it cannot be read.
std::set<std::string> SettingsIn(const std::filesystem::path& file);

// The names of all options of `app` and its commands that a settings file may have.
std::set<std::string> SettingNames(const CLI::App& app);

// The options of `command` with their values as a TOML file that ReadSettingsFile takes.
std::string SettingsText(const CLI::App& command);

}  // namespace enamel::program
