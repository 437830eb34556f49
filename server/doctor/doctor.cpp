#include "server/doctor/doctor.h"

#include <sys/resource.h>
#include <sys/timex.h>
#include <unistd.h>

#include <algorithm>
#include <boost/json.hpp>
#include <cmath>
#include <filesystem>

#include "common/base/counted.h"
#include "common/base/file.h"
#include "common/base/unix_time.h"
#include "common/net/certificate.h"
#include "common/net/frame_client.h"
#include "common/net/tls.h"
#include "common/net/web_question.h"
#include "common/protocol/messages.h"
#include "server/app/data_folder.h"
#include "server/jobs/backup_run.h"
#include "server/storage/folder/database_file.h"
#include "server/storage/folder/private_file.h"
#include "server/training/ticket_rules.h"

namespace enamel::server::app {

using program::Finding;
using program::Verdict;

namespace examined {
namespace {

namespace fs = std::filesystem;

constexpr size_t kMaxPemBytes = size_t{1} << 20;
constexpr UnixMs kDayMs = 24 * 3600 * 1000;
constexpr uint16_t kHttps = 443;

Finding Failed(const std::string& what, const Status& status, const std::string& advice = "") {
  return {what, Verdict::kFail, status.message(), advice};
}

// Where this machine reaches a listening address.
Result<net::Endpoint> ReachedAt(const std::string& listens) {
  ENAMEL_ASSIGN_OR_RETURN(net::Endpoint out, net::ParseEndpoint(listens));
  if (out.host == "0.0.0.0") out.host = "127.0.0.1";
  if (out.host == "::") out.host = "::1";
  return out;
}

std::string FirstHost(const ServeOptions& serve) {
  return serve.host_names.empty() ? std::string() : serve.host_names.front();
}

bool HasTls(const ServeOptions& serve) {
  return serve.http_self_signed || !serve.http_certificate.empty();
}

// A text of an answer, or of the error in it; empty: none.
std::string Member(const std::string& body, const char* name) {
  boost::system::error_code error;
  const boost::json::value value = boost::json::parse(body, error);
  const auto* object = error ? nullptr : value.if_object();
  if (object != nullptr && object->contains("error")) object = object->at("error").if_object();
  const boost::json::value* member = object == nullptr ? nullptr : object->if_contains(name);
  const auto* text = member == nullptr ? nullptr : member->if_string();
  return text == nullptr ? std::string() : std::string(*text);
}

}  // namespace

Finding Dates(const std::string& what, UnixMs until_ms, const std::string& renew) {
  constexpr UnixMs kSoonMs = 30 * kDayMs;
  const UnixMs left_ms = until_ms - enamel::UnixMs();
  const std::string until = "until " + TimeText(until_ms);
  if (left_ms <= 0) return {what, Verdict::kFail, "expired: it was valid " + until, renew};
  return {what, left_ms < kSoonMs ? Verdict::kWarn : Verdict::kOk, "valid " + until,
          left_ms < kSoonMs ? renew : ""};
}

void Folder(const ServeOptions& serve, Findings& out) {
  std::error_code error;
  const fs::file_status status = fs::status(serve.data, error);
  if (!fs::is_directory(status)) {
    out.push_back({"data folder", Verdict::kFail, "there is none at " + serve.data.string(),
                   "make it with enamel-server init, or name the right one with --data"});
    return;
  }
  const bool open =
      (status.permissions() & (fs::perms::group_all | fs::perms::others_all)) != fs::perms::none;
  if (open) {
    out.push_back({"data folder", Verdict::kFail, "others than its owner may enter it",
                   "chmod 700 " + serve.data.string()});
  } else if (::access(serve.data.c_str(), W_OK) != 0) {
    out.push_back({"data folder", Verdict::kFail, "this user may not write to it",
                   "run this command as the server's user: runuser -u enamel -- …"});
  } else {
    out.push_back({"data folder", Verdict::kOk, serve.data.string(), ""});
  }
  for (const char* name : {"ticket.key", "station.key", "page.key"}) {
    const fs::path file = serve.data / name;
    if (!fs::exists(file, error)) continue;
    const auto read = ReadPrivateFile(file, kMaxPemBytes, name, "restore it from a backup");
    if (!read.ok()) out.push_back(Failed("secret files", read.status()));
  }
}

void Machine(const ServeOptions& serve, Findings& out) {
  std::error_code error;
  const fs::space_info space = fs::space(serve.data, error);
  const uint64_t kept = uint64_t(serve.min_free_mib) << 20;
  const std::string found = std::to_string(space.available >> 20) + " MiB are free, below " +
                            std::to_string(serve.min_free_mib) + " MiB recordings wait";
  if (!error && space.available < 2 * kept) {
    out.push_back({"disk", space.available < kept ? Verdict::kFail : Verdict::kWarn, found,
                   "make room where " + serve.data.string() + " is, or move it to a larger disk"});
  } else if (!error) {
    out.push_back({"disk", Verdict::kOk, found, ""});
  }
  timex clock{};
  const bool kept_right = ::adjtimex(&clock) != TIME_ERROR && (clock.status & STA_UNSYNC) == 0;
  out.push_back({"clock", kept_right ? Verdict::kOk : Verdict::kWarn,
                 kept_right ? "kept right by a time server" : "nothing keeps it right",
                 kept_right ? ""
                            : "install chrony or systemd-timesyncd: certificates, tickets and "
                              "requests to S3 stores need the time"});
  constexpr rlim_t kFewFiles = 4096;
  rlimit files{};
  if (::getrlimit(RLIMIT_NOFILE, &files) == 0 && files.rlim_max < kFewFiles) {
    out.push_back({"open files", Verdict::kWarn,
                   "this process may open " + std::to_string(files.rlim_max),
                   "each station and browser takes one: raise LimitNOFILE"});
  }
}

void Certificates(const ServeOptions& serve, Findings& out) {
  const auto dates = [&](const std::string& what, const fs::path& file, const std::string& renew) {
    const auto pem = ReadFile(file, kMaxPemBytes);
    if (!pem.ok()) return out.push_back(Failed(what, pem.status(), renew));
    const auto time = net::CertificateTimeOf(*pem);
    if (!time.ok()) return out.push_back(Failed(what, time.status(), renew));
    if (time->from_ms > enamel::UnixMs()) {
      return out.push_back({what, Verdict::kFail,
                            "not valid yet: it is from " + TimeText(time->from_ms),
                            "check this machine's clock, or use a certificate that is valid now"});
    }
    if (const std::string problem = net::ChainProblem(*pem); !problem.empty()) {
      out.push_back({what, Verdict::kWarn, "out of order: " + file.string(), problem});
    }
    out.push_back(Dates(what, time->until_ms, renew));
  };
  std::error_code error;
  const fs::path station = serve.data / "station.crt";
  if (fs::exists(station, error)) {
    dates("stations' link", station,
          "a new one means to enrol every station again: see \"Limitations\" in server/README.md");
  }
  const bool own = serve.http_self_signed;
  if (!HasTls(serve)) return;
  const fs::path file = own ? serve.data / "page.crt" : serve.http_certificate;
  const fs::path key = own ? serve.data / "page.key" : serve.http_key;
  if (own && !fs::exists(file, error)) return;  // made at the first start
  if (const auto pair = net::MakeServerContext(file, key); !pair.ok()) {
    out.push_back(Failed("page's TLS", pair.status()));
    return;
  }
  dates("page's TLS", file,
        own ? "delete page.crt and page.key and restart the server: it makes others"
            : "renew it; the server takes new files within a minute");
}

void Running(const ServeOptions& serve, Findings& out) {
  const auto page = ReachedAt(serve.http), link = ReachedAt(serve.stations);
  if (!page.ok()) return out.push_back(Failed("page's port", page.status()));
  if (!link.ok()) return out.push_back(Failed("stations' port", link.status()));
  net::WebQuestion question{page->host, page->port, HasTls(serve), FirstHost(serve), "/readyz"};
  const auto answer = net::Ask(question);
  if (!answer.ok()) {
    const bool nobody = answer.status().code() == Code::kUnavailable;
    out.push_back({"server", nobody ? Verdict::kWarn : Verdict::kFail, answer.status().message(),
                   nobody ? "start it: systemctl start enamel-server; journalctl -u enamel-server "
                            "says why it does not start"
                          : "another program has this port: end it, or change --http"});
    return;
  }
  const std::string status = Member(answer->body, "status");
  const std::string problem = Member(answer->body, "problem"),
                    waiting = Member(answer->body, "waiting");
  if (status.empty()) {
    out.push_back({"server", Verdict::kFail,
                   "what answers at " + page->Text() + " is not this server, or does not know " +
                       question.host_name,
                   "check --http and --host-name; end another program that has this port"});
    return;
  }
  const std::string why = problem.empty() ? waiting : problem;
  out.push_back({"server",
                 status == "ok"                                 ? Verdict::kOk
                 : status == "degraded" || status == "draining" ? Verdict::kWarn
                                                                : Verdict::kFail,
                 "it says " + status + (why.empty() ? "" : ": " + why), ""});
  const auto pem = ReadFile(serve.data / "station.crt", kMaxPemBytes);
  const Result<Sha256> fingerprint =
      pem.ok() ? net::CertificateFingerprint(*pem) : Result<Sha256>(pem.status());
  if (!fingerprint.ok()) return;
  net::FrameClient client;
  const Status connected = client.Connect(*link, *fingerprint, std::chrono::seconds(5));
  out.push_back({"stations' port", connected.ok() ? Verdict::kOk : Verdict::kFail,
                 connected.ok() ? "open at " + link->Text() : connected.message(), ""});
}

namespace {

// What stations meet at the proxy.
Finding StationsThrough(const ServeOptions& serve, const std::string& host, uint16_t port) {
  const std::string what = "proxy, stations";
  const auto pem = ReadFile(serve.data / "station.crt", kMaxPemBytes);
  if (!pem.ok()) return Failed(what, pem.status());
  const auto fingerprint = net::CertificateFingerprint(*pem);
  if (!fingerprint.ok()) return Failed(what, fingerprint.status());
  constexpr std::chrono::seconds kWait{5};
  net::FrameClient client;
  const Status connected = client.Connect({host, port}, *fingerprint, kWait);
  if (connected.code() == Code::kUnauthenticated) {
    return Failed(what, connected,
                  "let the proxy pass stations' bytes on (mode tcp): their TLS ends at the server");
  }
  if (!connected.ok()) {
    return {
        what, Verdict::kWarn, connected.message(),
        "where stations use another address or port, try from a station: enamel-station doctor"};
  }
  wire::Request request;
  request.set_id(1);
  request.mutable_ping();
  if (Status sent = client.Send(protocol::Serialize(request), kWait); !sent.ok())
    return Failed(what, sent);
  const auto frame = client.Receive(kWait);
  if (!frame.ok()) return Failed(what, frame.status());
  const auto reply = protocol::ParseReply(*frame);
  // The station port refuses a client without Hello so; any other refusal is a fault on the way.
  const bool well = reply.ok() && reply->error().code() == CodeName(Code::kUnauthenticated);
  if (well) return {what, Verdict::kOk, "passed on at " + host + ":" + std::to_string(port), ""};
  return {what, Verdict::kFail, reply.ok() ? reply->error().message() : reply.status().message(),
          "compare the proxy's settings with haproxy.cfg (send-proxy-v2)"};
}

}  // namespace

void Proxy(const ServeOptions& serve, Findings& out) {
  if (serve.http_proxies.empty()) return;
  const std::string host = FirstHost(serve);
  if (host.empty()) {
    out.push_back({"proxy", Verdict::kFail, "the server knows no host name of the page",
                   "name it with --host-name"});
    return;
  }
  // Refused without a session, after the checks of what the proxy adds.
  const auto answer = net::Ask({host, kHttps, true, host, "/api/v1/session"});
  if (!answer.ok()) {
    out.push_back(Failed("proxy, page", answer.status(),
                         "check that the proxy runs, and that " + host + " leads to it"));
    return;
  }
  const std::string message = Member(answer->body, "message");
  if (answer->status == 401) {
    out.push_back({"proxy, page", Verdict::kOk, "its headers arrive", ""});
  } else if (answer->status == 403 || answer->status == 421) {
    out.push_back(
        {"proxy, page", Verdict::kFail, message,
         "compare the proxy's settings with haproxy.cfg, and --http-behind-proxy with its "
         "address"});
  } else {
    out.push_back(
        {"proxy, page", Verdict::kFail,
         "it answers " + std::to_string(answer->status) + (message.empty() ? "" : ": " + message),
         "503: no server that it knows says at /readyz that it is well"});
  }
  if (answer->certificate) {
    const auto& certificate = *answer->certificate;
    out.push_back(Dates("proxy's TLS", certificate.until_ms, "renew it at the proxy"));
    if (!certificate.problem.empty()) {
      out.push_back({"proxy's TLS", Verdict::kWarn, "browsers would warn: " + certificate.problem,
                     "give the proxy a certificate for " + host + " with its chain"});
    }
  }
  if (serve.station_proxies.empty()) return;
  const auto link = net::ParseEndpoint(serve.stations);
  if (link.ok()) out.push_back(StationsThrough(serve, host, link->port));
}

Finding RestoreDrill(const ServeOptions& serve, AuditRows& audit) {
  const std::string what = "restore drill";
  if (serve.backups.empty()) {
    return {what, Verdict::kWarn, "the server makes none, as it knows no folder for backups",
            "backups = \"/var/backups/enamel\" in the settings, and restart the server"};
  }
  const auto last = BackupRun::LastDrill(audit);
  if (!last.ok()) return Failed(what, last.status());
  if (!*last) return {what, Verdict::kOk, "none yet; the server makes one every week", ""};
  const std::string when = TimeText((*last)->at_ms), problem = (*last)->problem;
  if (!problem.empty()) {
    return {what, Verdict::kWarn, "the one of " + when + " failed: " + problem,
            "enamel-server verify --newest " + serve.backups.string() + "; then make a backup"};
  }
  const bool old = enamel::UnixMs() - (*last)->at_ms > 3 * 7 * kDayMs;
  return {what, old ? Verdict::kWarn : Verdict::kOk, "the last was passed on " + when,
          old ? "look for \"restore drill\" in journalctl -u enamel-server" : ""};
}

void Backups(const ServeOptions& serve, Findings& out) {
  const std::string what = "backup";
  // Opening the store would mend the folder, and bring the schema up to date.
  const auto keeps = [](const Finding& finding) {
    return finding.verdict != Verdict::kOk &&
           (finding.what == "data folder" || finding.what == "database" ||
            finding.what == "schema");
  };
  if (std::ranges::any_of(out, keeps)) {
    out.push_back({what, Verdict::kWarn, "not looked for, because of what is wrong above",
                   "mend that, and run this command again"});
    return;
  }
  const auto store = OpenForCommand(serve.data);
  if (!store.ok()) {
    out.push_back(Failed(what, store.status(), "nothing is known of backups without the database"));
    return;
  }
  const auto newest = (*store)->audit.NewestOf(kBackupMade);
  if (!newest.ok()) return out.push_back(Failed(what, newest.status()));
  const std::string mend =
      "systemctl enable --now enamel-backup.timer; journalctl -u enamel-backup";
  if (!*newest) {
    out.push_back({what, Verdict::kWarn, "none was made yet", mend});
    return;
  }
  const UnixMs age_ms = enamel::UnixMs() - (*newest)->at_ms;
  if (age_ms < -kDayMs) {
    out.push_back({what, Verdict::kWarn,
                   "the newest is dated " + TimeText((*newest)->at_ms) +
                       ", in the future: a clock was wrong, and its age is unknown",
                   "let a time server keep the clock, then make a backup: enamel-server backup"});
    out.push_back(RestoreDrill(serve, (*store)->audit));
    return;
  }
  const bool old = age_ms > 2 * kDayMs;
  out.push_back({what, old ? Verdict::kWarn : Verdict::kOk,
                 "the newest is of " + TimeText((*newest)->at_ms), old ? mend : ""});
  out.push_back(RestoreDrill(serve, (*store)->audit));
}

}  // namespace examined

std::vector<Finding> Examine(const ServeOptions& serve) {
  std::vector<Finding> out;
  for (const auto part :
       {examined::Folder, examined::Machine, examined::Database, examined::Buckets,
        examined::Certificates, examined::Running, examined::Proxy, examined::Backups}) {
    part(serve, out);
  }
  return out;
}

}  // namespace enamel::server::app
