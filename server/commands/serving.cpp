#include "server/commands/serving.h"

#include <iostream>
#include <memory>

#include "common/program/log.h"
#include "common/program/settings.h"
#include "server/app/seed.h"
#include "server/app/serve.h"
#include "server/app/work.h"
#include "server/commands/command_line.h"

namespace enamel::server::app {
namespace {

struct ServeCommand {
  ServeOptions serve;
  std::filesystem::path config;
  bool print_settings = false;
  program::LogOptions log;
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
                  "Numeric address of the proxy that speaks TLS to the browsers and sets\n"
                  "X-Forwarded-For and X-Forwarded-Proto; nobody else is answered (repeatable)");
  cmd->add_option("--stations-behind-proxy", serve.station_proxies,
                  "Numeric address of a proxy that passes stations' bytes on and says for whom\n"
                  "(send-proxy-v2); others may still connect themselves (repeatable)");
  cmd->add_option("--host-name", serve.host_names, "Name the page is reached under (repeatable)");
  cmd->add_option("--page-url", serve.page_url,
                  "Address under which people open the page; stations show it to people they send\n"
                  "there. Without it: made from the first --host-name");
}

void AddOperations(CLI::App* cmd, ServeCommand& o) {
  cmd->add_option("--job-threads", o.serve.job_threads, "Attempts scored at once; 0: scoring waits")
      ->check(CLI::Range(0, 64))
      ->capture_default_str();
  cmd->add_option(
         "--drain-seconds", o.serve.drain_s,
         "From being asked to stop until it does: /healthz is 503, so that a load balancer\n"
         "sends no more, and what comes is still answered")
      ->check(CLI::Range(0, 3600))
      ->capture_default_str();
  cmd->add_option("--min-free-mib", o.serve.min_free_mib,
                  "With less free, recordings are refused and wait at the stations; 0: never")
      ->check(CLI::Range(0, 1 << 20))
      ->capture_default_str();
  cmd->add_option("--one-time-password-days", o.serve.one_time_password_days,
                  "How long a password that the server made up can be used, for one sign-in")
      ->check(CLI::Range(1, 90))
      ->capture_default_str();
  cmd->add_option("--metrics-token-file", o.serve.metrics_token_file,
                  "File with the token that GET /metrics asks for; without it, only this machine\n"
                  "may ask")
      ->check(CLI::ExistingFile);
  cmd->add_option("--log-format", o.log.format, "text, or json: one object a line")
      ->capture_default_str();
  cmd->add_option("--log-level", o.log.level, "trace, debug, info, warning or error")
      ->capture_default_str();
}

// After the command line: the environment, the file, and required settings.
Status FinishServe(CLI::App& cmd, ServeCommand& o) {
  // Each sets only options not set yet, so the order is the order of precedence.
  ENAMEL_RETURN_IF_ERROR(program::ReadEnvironment(cmd));
  if (!o.config.empty()) ENAMEL_RETURN_IF_ERROR(program::ReadSettingsFile(o.config, cmd));
  // Not the parser's `required()`: it asks before environment and file have been read.
  if (o.serve.data.empty()) {
    return Status(Code::kInvalidInput,
                  "serve needs a data folder: --data DIR, ENAMEL_DATA, or data = \"DIR\" in the "
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
  return program::SetUpLog(o.log);
}

}  // namespace

void DeclareServe(CommandGroup root) {
  CLI::App* cmd = root.parent.add_subcommand("serve", "Run the server until Ctrl-C");
  auto options = std::make_shared<ServeCommand>();
  ServeCommand& o = *options;
  cmd->add_option("--data", o.serve.data, "Data folder; made when absent");
  AddIdentity(cmd, o.serve.identity);
  AddAddresses(cmd, o.serve);
  AddOperations(cmd, o);
  cmd->add_option("--config", o.config, "TOML file with any of these settings")
      ->check(CLI::ExistingFile);
  cmd->add_flag("--print-settings", o.print_settings,
                "Print all settings as such a file, wherever they came from, and end");
  cmd->footer(
      "Every setting can come from the command line, from the environment (--job-threads is\n"
      "ENAMEL_JOB_THREADS) or from the file; the nearer one wins, in this order.\n\n"
      "  enamel-server serve --data /srv/enamel                   try it, on this machine only\n"
      "  enamel-server serve --config /etc/enamel/server.toml     as a service (server/ops)\n\n"
      "Watch it with GET /healthz (503 when no recordings are taken) and GET /metrics "
      "(Prometheus).");
  // Not by Declare: the action needs the command itself, for the other sources of settings.
  cmd->callback([options, cmd, &chosen = root.chosen] {
    chosen = [options, cmd]() -> Status {
      ENAMEL_RETURN_IF_ERROR(FinishServe(*cmd, *options));
      if (options->print_settings) {
        std::cout << program::SettingsText(*cmd);
        return Status::Ok();
      }
      return Serve(options->serve);
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
      "A class that hands in at the same time is scored sooner the more of these run. Each job is\n"
      "done by one of them. Start as many as there are processors to spare; stop them whenever "
      "you\n"
      "like: what one was at goes back to the queue, and is taken by another within half a minute\n"
      "when it was killed.\n\n"
      "  enamel-server work --data /srv/enamel --threads 4");
}

void DeclareSeed(CommandGroup root) {
  auto [cmd, o] = Declare<SeedOptions>(
      root, "seed-demo", "Add demo people, profiles, molar and exercise; changes nothing twice",
      SeedDemo);
  AddData(cmd, o.data);
  cmd->add_option("--scene", o.scene, "Folder of an imported scene to offer as well");
  cmd->add_option("--voxel-um", o.voxel_um, "Voxel size of the built-in molar")
      ->check(CLI::Range(20, 500))
      ->capture_default_str();
  cmd->add_option("--json", o.json, "Write the facts to this file");
}

}  // namespace enamel::server::app
