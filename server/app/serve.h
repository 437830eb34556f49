#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "common/base/result.h"
#include "server/ops/budgets.h"

namespace enamel::server::app {

struct ServeOptions {
  std::filesystem::path data;
  std::filesystem::path identity;       // of another server (TakeIdentity); empty: its own
  std::string http = "127.0.0.1:8080";  // numeric address:port
  std::string stations = "127.0.0.1:8443";
  std::filesystem::path web;                         // the built page; empty: API only
  std::filesystem::path http_certificate, http_key;  // both or none; TLS for the page
  bool http_self_signed = false;          // page.crt, page.key in the data folder, made when absent
  std::vector<std::string> http_proxies;  // numeric addresses; no one else is answered
  // Numeric addresses whose connections to the station link begin with the PROXY protocol
  // (ListenerOptions::proxies).
  std::vector<std::string> station_proxies;
  std::vector<std::string> host_names;  // the page may be asked for under; needed beyond loopback
  // Where people open the page, which stations tell them (protocol::IsPageUrl). Empty: made of the
  // first of host_names; without one it is not told.
  std::string page_url;
  int io_threads = 2;  // of the page, and of the stations
  int job_threads = 1;
  ops::Budgets budgets{};
  int min_free_mib = 256;                 // recordings are refused when the disk has less
  int drain_s = 0;                        // from the first signal until it stops, /readyz is 404
  int one_time_password_days = 7;         // a password that was made up can be used so long
  std::filesystem::path backups;          // where the page's backups go (BackupRun); empty: nowhere
  std::filesystem::path backups_keyring;  // as `backup --keyring`
  std::filesystem::path metrics_token_file;  // empty: /metrics is for this machine only
};

// Runs until SIGINT or SIGTERM. Prints one line "ready …" to standard output when page and station
// link listen. A first signal lets requests finish (drain_s, then at most some seconds); further
// ones within 2 s of it change nothing, later ones end it at once. Nothing that was acknowledged is
// lost.
Status Serve(const ServeOptions& options);

}  // namespace enamel::server::app
