#include "server/commands/serving.h"

#include <algorithm>
#include <cstdlib>
#include <iostream>
#include <memory>

#include "common/program/command_settings.h"
#include "common/program/example.h"
#include "common/program/findings.h"
#include "common/program/output.h"
#include "common/program/settings.h"
#include "server/app/seed.h"
#include "server/app/work.h"
#include "server/commands/command_line.h"
#include "server/commands/console_phases.h"
#include "server/doctor/doctor.h"
#include "server/doctor/support_bundle.h"

namespace enamel::server::app {
namespace {

struct ServeCommand {
  ServeSettings settings;
  bool print_settings = false;
};

void AddAddresses(CLI::App* cmd, ServeOptions& serve) {
  cmd->add_option("--http", serve.http, "Page and API: address:port")->capture_default_str();
  cmd->add_option("--stations", serve.stations, "Station link: address:port")
      ->capture_default_str();
  cmd->add_option("--web", serve.web, "Folder of the built page (web/dist)");
  cmd->add_option("--http-cert", serve.http_certificate,
                  "Certificate chain of the page, PEM. Beyond loopback the page needs this,\n"
                  "--http-self-signed or --http-behind-proxy");
  cmd->add_option("--http-key", serve.http_key, "Its key, PEM");
  cmd->add_flag("--http-self-signed", serve.http_self_signed,
                "Make a certificate for the first --host-name, to start with");
  cmd->add_option("--http-behind-proxy", serve.http_proxies,
                  "Numeric address of the proxy that ends the browsers' TLS and sets\n"
                  "X-Forwarded-For and X-Forwarded-Proto; only it is answered (repeatable)");
  cmd->add_option("--stations-behind-proxy", serve.station_proxies,
                  "Numeric address of a proxy that forwards stations' connections and sends their\n"
                  "addresses (send-proxy-v2); stations may still connect directly (repeatable)");
  cmd->add_option("--host-name", serve.host_names, "Host name of the page (repeatable)");
  cmd->add_option("--page-url", serve.page_url,
                  "Address under which people open the page; stations show it to people.\n"
                  "Without it: made from the first --host-name");
}

void AddOperations(CLI::App* cmd, ServeSettings& o) {
  cmd->add_option("--job-threads", o.serve.job_threads,
                  "Attempts scored at the same time; 0: none, scoring waits")
      ->check(CLI::Range(0, 64))
      ->capture_default_str();
  cmd->add_option(
         "--drain-seconds", o.serve.drain_s,
         "Time between the request to stop and stopping. Meanwhile requests are still answered,\n"
         "and /readyz is 404, so that a load balancer sends no more")
      ->check(CLI::Range(0, 3600))
      ->capture_default_str();
  cmd->add_option("--min-free-mib", o.serve.min_free_mib,
                  "With less free space, recordings are refused and wait at the stations; 0: never")
      ->check(CLI::Range(0, 1 << 20))
      ->capture_default_str();
  cmd->add_option("--one-time-password-days", o.serve.one_time_password_days,
                  "How long a one-time password made by the server is valid")
      ->check(CLI::Range(1, 90))
      ->capture_default_str();
  cmd->add_option("--backups", o.serve.backups,
                  "Folder for the backups that admins start on the page; without it they cannot");
  cmd->add_option("--backups-keyring", o.serve.backups_keyring,
                  "Keep the keys of these backups in this folder (backup --keyring)");
  cmd->add_option("--metrics-token-file", o.serve.metrics_token_file,
                  "File with the token that GET /metrics requires; without it, only this machine\n"
                  "may read them")
      ->check(CLI::ExistingFile);
  program::AddLogOptions(*cmd, o.log);
}

// In a section of their own of the settings file.
void AddBudgets(CLI::App* cmd, ops::Budgets& budgets) {
  for (const ops::BudgetKind* kind : ops::kBudgets) {
    std::string name = "--budgets-" + std::string(kind->name);
    std::ranges::replace(name, '_', '-');
    cmd->add_option(name, budgets.*kind->limit, kind->what)
        ->check(CLI::Range(kind->least, kind->most))
        ->group("budgets")
        ->capture_default_str();
  }
}

}  // namespace

void AddServeSettings(CLI::App* cmd, ServeSettings& settings) {
  cmd->add_option("--data", settings.serve.data, "Data folder; made when absent");
  AddIdentity(cmd, settings.serve.identity);
  AddAddresses(cmd, settings.serve);
  AddOperations(cmd, settings);
  AddBudgets(cmd, settings.serve.budgets);
  cmd->add_option("--config", settings.config, "TOML file with any of these settings")
      ->check(CLI::ExistingFile);
}

// After the command line: the environment, the file, and required settings.
Status FinishServeSettings(CLI::App& cmd, ServeSettings& o) {
  // Each sets only options not set yet, so the order is the order of precedence.
  ENAMEL_RETURN_IF_ERROR(program::ReadEnvironment(cmd));
  if (!o.config.empty()) ENAMEL_RETURN_IF_ERROR(program::ReadSettingsFile(o.config, cmd));
  // Not the parser's `required()`: it asks before environment and file have been read.
  if (o.serve.data.empty()) {
    return Status(Code::kInvalidInput,
                  cmd.get_name() +
                      " needs a data folder: --data DIR, ENAMEL_DATA, or data = \"DIR\" in the "
                      "settings file");
  }
  if (o.serve.http_certificate.empty() != o.serve.http_key.empty()) {
    return Status(Code::kInvalidInput, "--http-cert and --http-key go together; give both or none");
  }
  if (o.serve.http_self_signed && !o.serve.http_key.empty()) {
    return Status(Code::kInvalidInput,
                  "--http-self-signed makes the certificate that --http-cert gives; choose one");
  }
  // Last: format and level may have come from the file. Earlier refusals used the format that
  // `main` chose.
  // Also for a backup, which is a process of its own.
  ::setenv("ENAMEL_LOG_FORMAT", o.log.format.c_str(), 1);
  return program::SetUpLog(o.log);
}

void DeclareServe(CommandGroup root) {
  CLI::App* cmd = root.parent.add_subcommand("serve", "Run the server until Ctrl-C");
  auto options = std::make_shared<ServeCommand>();
  AddServeSettings(cmd, options->settings);
  cmd->add_flag("--print-settings", options->print_settings,
                "Print the settings in use as such a file, and exit");
  cmd->footer(
      "Every setting can come from the command line, from the environment (--job-threads is\n"
      "ENAMEL_JOB_THREADS) or from the file; the first of these wins.\n"
      "Watch it with GET /readyz (503 when no recordings are taken) and GET /metrics "
      "(Prometheus).");
  program::AddExamples(*cmd, {"--data ~/enamel                      # try it, on this machine only",
                              "--config /etc/enamel/server.toml     # as the unit does"});
  // Not by Declare: the action needs the command itself, for the other sources of settings.
  cmd->callback([options, cmd, &chosen = root.chosen] {
    chosen = [options, cmd]() -> Status {
      ENAMEL_RETURN_IF_ERROR(FinishServeSettings(*cmd, options->settings));
      if (options->print_settings) {
        std::cout << program::SettingsText(*cmd);
        return Status::Ok();
      }
      return Serve(options->settings.serve);
    };
  });
}

void DeclareDoctor(CommandGroup root) {
  struct DoctorCommand {
    ServeSettings settings;
    std::filesystem::path json;
  };
  CLI::App* cmd = root.parent.add_subcommand(
      "doctor", "Check what the server needs, and say how to mend each fault");
  auto options = std::make_shared<DoctorCommand>();
  AddServeSettings(cmd, options->settings);
  cmd->add_option("--json", options->json, "Write the findings to this file");
  cmd->footer(
      "Takes the settings of serve. Run it as the server's user, beside the server or without it:\n"
      "  runuser -u enamel -- enamel-server doctor --config /etc/enamel/server.toml\n"
      "Exit code 1 when something failed; warnings are no failure.");
  cmd->callback([options, cmd, &chosen = root.chosen] {
    chosen = [options, cmd]() -> Status {
      ENAMEL_RETURN_IF_ERROR(FinishServeSettings(*cmd, options->settings));
      ENAMEL_RETURN_IF_ERROR(program::CheckOutputFile(options->json, "--json"));
      return program::Report(Examine(options->settings.serve), options->json, "missing or wrong");
    };
  });
}

void DeclareSupportBundle(CommandGroup root) {
  struct Asked {
    ServeSettings settings;
    std::filesystem::path target, log;
  };
  CLI::App* cmd = root.parent.add_subcommand(
      "support-bundle",
      "Write what helps somebody else to find a fault, without names and secrets");
  auto options = std::make_shared<Asked>();
  cmd->add_option("FILE", options->target, "File to write; -: standard output")->required();
  AddServeSettings(cmd, options->settings);
  cmd->add_option("--log", options->log, "The server's log; -: standard input");
  cmd->footer(
      "One JSON document: read it before you send it. Takes the settings of serve.\n"
      "  journalctl -u enamel-server -o cat -n 5000 | runuser -u enamel -- enamel-server "
      "support-bundle \\\n"
      "    /tmp/enamel.json --config /etc/enamel/server.toml --log -");
  cmd->callback([options, cmd, &chosen = root.chosen] {
    chosen = [options, cmd]() -> Status {
      ENAMEL_RETURN_IF_ERROR(FinishServeSettings(*cmd, options->settings));
      return SupportBundle(
          {options->settings.serve, program::SettingsText(*cmd), options->target, options->log});
    };
  });
}

void DeclareWork(CommandGroup root) {
  auto [cmd, o] = Declare<WorkOptions>(
      root, "work", "Score attempts beside a server, on this machine or another, until Ctrl-C",
      Work);
  AddData(cmd, o.data);
  AddIdentity(cmd, o.identity);
  cmd->add_option("--threads", o.threads, "Attempts scored at once")
      ->check(CLI::Range(1, 64))
      ->capture_default_str();
  cmd->footer(
      "Run more of these to score a whole class sooner; each job is done by one of them. Start as\n"
      "many as there are spare processors, and stop them at any time: an unfinished job goes back\n"
      "to the queue, within half a minute if its worker was killed.");
  AddExample(cmd, "--threads 4");
}

void DeclareSeed(CommandGroup root) {
  auto [cmd, o] = Declare<SeedOptions>(
      root, "seed-demo", "Add demo people, profiles, molar and exercise; changes nothing twice",
      [](const SeedOptions& wanted) {
        ConsolePhases phases;
        return SeedDemo(wanted, [&](const std::string& part) { phases.Begin(part); });
      });
  AddData(cmd, o.data);
  cmd->add_option("--scene", o.scene, "Folder of an imported scene to offer as well");
  cmd->add_option("--voxel-um", o.voxel_um, "Voxel size of the built-in molar")
      ->check(CLI::Range(20, 500))
      ->capture_default_str();
  cmd->add_option("--json", o.json, "Write the facts to this file");
  AddExample(cmd, "");
}

}  // namespace enamel::server::app
