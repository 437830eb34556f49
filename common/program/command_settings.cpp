#include "common/program/command_settings.h"

#include <CLI/CLI.hpp>
#include <cstdlib>
#include <functional>
#include <set>
#include <utility>

namespace enamel::program {

void AddLogOptions(CLI::App& app, LogOptions& log) {
  app.add_option("--log-format", log.format, "Format of the log; json: one object a line")
      ->check(CLI::IsMember({"text", "json"}))
      ->capture_default_str();
  app.add_option("--log-level", log.level, "Least level that is logged")
      ->check(CLI::IsMember({"trace", "debug", "info", "warning", "error"}))
      ->capture_default_str();
}

CommandSettings::CommandSettings(CLI::App& app, Where where)
    : app_(app), where_(std::move(where)), log_{.name = where_.program} {}

void CommandSettings::Add() {
  app_.add_option("--config", config_,
                  "Settings file (TOML); also " + EnvironmentName("config", where_.prefix) +
                      ", else " + where_.system_file.string() + " if it is there");
  AddLogOptions(app_, log_);
  std::function<void(CLI::App&)> prepare = [&](CLI::App& parent) {
    for (CLI::App* command : parent.get_subcommands([](CLI::App*) { return true; })) {
      command->fallthrough();
      command->parse_complete_callback([this, command] {
        if (Status s = Apply(*command); !s.ok()) throw CLI::ValidationError(s.message());
      });
      prepare(*command);
    }
  };
  prepare(app_);
}

Status CommandSettings::Apply(CLI::App& command) {
  // They belong to the program, whose options are taken over after its command's.
  for (const char* name : {"--config", "--log-format", "--log-level"}) {
    if (CLI::Option* option = app_.get_option(name); option->count() > 0) option->run_callback();
  }
  std::filesystem::path file = config_;
  if (const char* set = std::getenv(EnvironmentName("config", where_.prefix).c_str());
      file.empty() && set != nullptr) {
    file = set;
  }
  if (file.empty() && std::filesystem::exists(where_.system_file)) file = where_.system_file;
  std::set<std::string> known = SettingNames(app_);
  if (where_.shared) known.insert(kAnyKey);
  std::set<std::string> nearer;
  for (CLI::App* one : {&command, &app_}) {
    ENAMEL_RETURN_IF_ERROR(ReadEnvironment(*one, where_.prefix));
    nearer.merge(GivenSettings(*one));
    if (file.empty()) continue;
    ENAMEL_RETURN_IF_ERROR(ReadSettingsFile(file, *one, known));
  }
  own_ = SettingsIn(file);
  for (const std::string& name : known) {
    if (std::getenv(EnvironmentName(name, where_.prefix).c_str()) != nullptr) own_.insert(name);
  }
  const std::vector<std::string> wrong = TakePolicy(command, nearer, known);
  ENAMEL_RETURN_IF_ERROR(SetUpLog(log_));
  for (const std::string& what : wrong) SayWarning("the server's policy: " + what + "; ignored");
  return Status::Ok();
}

std::vector<std::string> CommandSettings::TakePolicy(CLI::App& command,
                                                     const std::set<std::string>& nearer,
                                                     const std::set<std::string>& known) {
  const CLI::Option* data = command.get_option_no_throw("--data");
  if (!where_.policy || data == nullptr) return {};
  // Not its results, which are empty while nothing gave it.
  const std::vector<PolicySetting> policy =
      where_.policy(data->results().empty() ? data->get_default_str() : data->results().front());
  std::vector<std::string> wrong;
  for (CLI::App* one : {&command, &app_}) {
    for (std::string& what : ApplyPolicy(policy, *one, nearer)) wrong.push_back(std::move(what));
  }
  for (const PolicySetting& setting : policy) {
    if (!known.contains(setting.name)) wrong.push_back("no setting is called " + setting.name);
  }
  return wrong;
}

}  // namespace enamel::program
