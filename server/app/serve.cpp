#include "server/app/serve.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/address.hpp>
#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <functional>
#include <future>
#include <iostream>
#include <optional>
#include <thread>

#include "common/base/file.h"
#include "common/base/unix_time.h"
#include "common/net/certificate.h"
#include "common/net/frame_client.h"
#include "common/protocol/messages.h"
#include "server/app/data_folder.h"
#include "server/app/peers.h"
#include "server/app/school.h"
#include "server/app/school_folder.h"
#include "server/app/schools.h"
#include "server/app/seed.h"
#include "server/app/stop_signals.h"
#include "server/app/store_watch.h"
#include "server/auth/first_admin.h"
#include "server/http/api.h"
#include "server/http/wire/http_server.h"
#include "server/ops/metrics.h"
#include "server/stations/link_budget.h"
#include "server/stations/station_server.h"
#include "server/storage/folder/store_options.h"
#include "server/storage/open_store.h"
#include "server/storage/people/people_rows.h"
#include "server/storage/people/school_list.h"
#include "server/storage/store.h"

namespace enamel::server::app {
namespace {

namespace asio = boost::asio;

// Longer than either server's own deadline for stopping.
constexpr auto kStopWait = std::chrono::seconds(6);
// Chunks that wait for their commit at the same time: they share one sync.
constexpr size_t kStationThreads = 256;

// Where to listen. Unlike where to connect to, the port may be 0: any free one.
Result<net::Endpoint> ListenAddress(const std::string& text, const char* option) {
  // The parser of addresses to connect to refuses port 0. It gets a 1 in its place, and everything
  // else is checked as always.
  if (text.ends_with(":0")) {
    auto endpoint = net::ParseEndpoint(text.substr(0, text.size() - 1) + "1");
    if (endpoint.ok()) endpoint->port = 0;
    if (endpoint.ok()) return endpoint;
  }
  auto endpoint = net::ParseEndpoint(text);
  if (endpoint.ok()) return endpoint;
  return Status(Code::kInvalidInput,
                std::string(option) + " expects address:port, found \"" + text + "\"");
}

// Host names have no case.
std::vector<std::string> LowerCase(std::vector<std::string> names) {
  for (std::string& name : names) {
    std::ranges::transform(name, name.begin(), [](char c) {
      return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
    });
  }
  return names;
}

bool IsLoopback(const std::string& address) {
  boost::system::error_code error;
  auto parsed = asio::ip::make_address(address, error);
  return !error && parsed.is_loopback();
}

// The demo accounts' passwords are printed in our documents.
Status RefuseDemoBeyondLoopback(PeopleRows& people, const http::HttpOptions& page,
                                const stations::StationServerOptions& link) {
  // A proxy on this machine brings the whole world to a page on loopback.
  bool reached_from_afar = !IsLoopback(page.address) || !page.trusted_proxies.empty() ||
                           !IsLoopback(link.address) || !link.proxies.empty();
  if (!reached_from_afar) return Status::Ok();
  ENAMEL_ASSIGN_OR_RETURN(auto logins, LoginsWithDemoPassword(people));
  if (logins.empty()) return Status::Ok();
  std::string all;
  for (const std::string& login : logins) all += (all.empty() ? "" : ", ") + login;
  return Status(
      Code::kInvalidInput,
      "expected accounts with passwords of their own before others can reach this server, "
      "found the demo's public ones for " +
          all +
          "; give each another (admin set-password --login L) or disable it (admin "
          "disable --login L), or listen on 127.0.0.1 alone");
}

Result<http::HttpOptions> HttpOptionsOf(const ServeOptions& options) {
  ENAMEL_ASSIGN_OR_RETURN(auto endpoint, ListenAddress(options.http, "--http"));
  http::HttpOptions out;
  out.address = endpoint.host;
  out.port = endpoint.port;
  out.web_root = options.web;
  out.host_names = LowerCase(options.host_names);
  out.trusted_proxies = options.http_proxies;
  out.backups.folder = options.backups;
  out.backups.keyring = options.backups_keyring;
  // Logged with its fingerprint: a careful person compares it with the browser's.
  if (options.http_self_signed) {
    ENAMEL_ASSIGN_OR_RETURN(auto made, EnsurePageCertificate(options.data, options.host_names));
    spdlog::info("page: self-signed certificate {}, SHA-256 {}; browsers ask before they trust it",
                 made.certificate.string(), made.fingerprint.Hex());
    out.tls = http::TlsFiles{made.certificate, made.private_key};
  }
  if (!options.http_certificate.empty()) {
    out.tls = http::TlsFiles{options.http_certificate, options.http_key};
  }
  return out;
}

// The token of a file that only the server's user may read, say; a line end after it does not
// count.
Status ReadToken(const std::filesystem::path& file, std::string& token) {
  constexpr size_t kMinBytes = 16, kMaxBytes = 1024;
  if (file.empty()) return Status::Ok();
  ENAMEL_ASSIGN_OR_RETURN(auto bytes, ReadFile(file, kMaxBytes));
  token = AsText(bytes);
  // Editors and `echo` put one there, and nobody sees it.
  while (token.ends_with('\n') || token.ends_with('\r')) token.pop_back();
  if (token.size() >= kMinBytes) return Status::Ok();
  return Status(Code::kInvalidInput, "expected a token of at least 16 bytes in " + file.string() +
                                         ", found " + std::to_string(token.size()));
}

Result<stations::StationServerOptions> LinkOptionsOf(const ServeOptions& options,
                                                     const ServerIdentity& identity) {
  ENAMEL_ASSIGN_OR_RETURN(auto endpoint, ListenAddress(options.stations, "--stations"));
  stations::StationServerOptions out;
  out.address = endpoint.host;
  out.port = endpoint.port;
  out.certificate = identity.certificate;
  out.private_key = identity.private_key;
  out.proxies = options.station_proxies;
  return out;
}

// Behind a proxy the page is at the proxy's usual port.
std::string PageUrlOf(const std::string& host, const http::HttpOptions& http, uint16_t port) {
  constexpr uint16_t kHttps = 443, kHttp = 80;
  bool proxied = !http.trusted_proxies.empty(), https = proxied || http.tls;
  std::string url = (https ? "https://" : "http://") + host;
  if (!proxied && port != (https ? kHttps : kHttp)) url += ":" + std::to_string(port);
  // A host name that makes no address is not told at all: a station then names the
  // server it is linked to, and no wrong place.
  return protocol::IsPageUrl(url) ? url : std::string();
}

// Where a stranger cannot listen in: on this machine, or behind TLS here or at the proxy.
bool IsPrivate(const http::HttpOptions& page) {
  const bool proxied = !page.trusted_proxies.empty();
  return page.tls || proxied || IsLoopback(page.address);
}

Result<bool> HasAdmin(PeopleRows& people) {
  PeopleFilter admins;
  admins.role = Role::kAdmin;
  admins.limit = 1;
  ENAMEL_ASSIGN_OR_RETURN(const auto found, people.FindPeople(admins));
  return !found.empty();
}

// After '#', which no browser sends: no proxy's log has it. Standard output does, and a journal of
// it, for as long as the link is good.
void SayFirstAdmin(const std::string& page_url, const std::string& token) {
  std::cout << "first admin: open " << page_url << "/first#" << token << " within 24 hours"
            << std::endl;
}

// Runs each of `all` on its threads until it is out of work; `stopping` becomes ready with the first signal.
// False: some connections did not end in time and were closed.
bool RunUntilStopped(const std::vector<asio::io_context*>& all, int threads,
                     std::future<void> stopping) {
  auto ended = std::async(std::launch::async, [&] {
    std::vector<std::jthread> runners;
    // `run` returns when no handler is left, which is when the last connection has ended.
    for (asio::io_context* io : all) {
      for (int i = 0; i < threads; ++i) runners.emplace_back([io] { io->run(); });
    }
  });
  stopping.wait();
  const bool in_time = ended.wait_for(kStopWait) == std::future_status::ready;
  if (!in_time) {
    spdlog::warn("some connections did not end in time; closing them");
    for (asio::io_context* io : all) io->stop();
  }
  ended.wait();
  return in_time;
}

// What must be in order before anything listens.
struct Prepared {
  StoreOptions store_options;
  std::unique_ptr<Store> store;
  ServerIdentity identity;
  http::HttpOptions page;
  stations::StationServerOptions link;
};

Result<Prepared> Prepare(const ServeOptions& options) {
  if (!options.identity.empty()) {
    ENAMEL_RETURN_IF_ERROR(TakeIdentity(options.data, options.identity));
  }
  if (const auto installation = InstallationOf(options.data)) {
    return Status(Code::kInvalidInput,
                  "expected an installation's data folder, found a school's of " +
                      installation->string() + "; serve that one, which serves its schools");
  }
  Prepared out;
  out.store_options.folder = options.data;
  // Two servers on one folder would both hand out jobs and both believe in their own caches.
  out.store_options.hold_lock = true;
  out.store_options.min_free_bytes = uint64_t(options.min_free_mib) << 20;
  ENAMEL_ASSIGN_OR_RETURN(out.store, OpenStore(out.store_options));
  ENAMEL_ASSIGN_OR_RETURN(out.identity, EnsureMatchingIdentity(options.data, out.store->identity));
  ENAMEL_ASSIGN_OR_RETURN(out.page, HttpOptionsOf(options));
  ENAMEL_ASSIGN_OR_RETURN(out.link, LinkOptionsOf(options, out.identity));
  ENAMEL_RETURN_IF_ERROR(RefuseDemoBeyondLoopback(out.store->people, out.page, out.link));
  // Stations get it and show it; they refuse an invalid address, which nobody would notice here.
  if (!options.page_url.empty() && !protocol::IsPageUrl(options.page_url)) {
    return Status(Code::kInvalidInput,
                  "--page-url expects https:// or http:// and what follows, at most 200 characters "
                  "of ASCII without spaces, found \"" +
                      options.page_url + "\"",
                  "page-url");
  }
  ENAMEL_RETURN_IF_ERROR(ReadToken(options.metrics_token_file, out.page.metrics_token));
  return out;
}

// Returns the use that the parties of one school make of budgets that all schools share.
using BudgetsUsed = std::function<std::vector<ops::BudgetUse>(const stations::Services& school)>;

BudgetsUsed ServerBudgets(const ops::Budgets& limits,
                          std::shared_ptr<const stations::LinkBudget> link,
                          std::shared_ptr<const HeldBytes> bodies) {
  return [limits, link = std::move(link),
          bodies = std::move(bodies)](const stations::Services& school) {
    std::vector<ops::BudgetUse> out = link->Uses(&school, enamel::UnixMs());
    const HeldBytes::Use most = bodies->Most();
    ops::BudgetUse& use = out.emplace_back();
    use.kind = &ops::kBodies;
    use.limit = ops::LimitOf(ops::kBodies, limits);
    use.most = most.bytes;
    if (!most.of.empty()) use.party = ops::PartyKind::kAddress;
    use.of = most.of;
    use.refused = bodies->refused();
    return out;
  };
}

// Opens the other schools of the installation, once the ports are known.
struct OpenOther {
  const ServeOptions& options;
  const StoreOptions& store_options;
  const SchoolOptions& school_options;
  const http::HttpOptions& page;
  const stations::StationServerOptions& link;
  const BudgetsUsed& budgets_used;
  uint16_t page_port = 0, link_port = 0;

  void WarnOfOwnHosts(const SchoolRow& row) const {
    const std::vector<std::string> local{"127.0.0.1", "localhost"};
    const auto& own = page.host_names.empty() ? local : page.host_names;
    for (const std::string& host : row.hosts) {
      if (std::ranges::count(own, host) == 0) continue;
      spdlog::warn(
          "school {} is listed as {}, which is this installation's own school's; give it "
          "another host name: school set-hosts",
          row.name, host);
    }
  }

  Result<Schools::Opened> Open(const SchoolRow& row) const {
    WarnOfOwnHosts(row);
    ENAMEL_ASSIGN_OR_RETURN(auto its, OpenSchool(options.data, row, store_options));
    ENAMEL_RETURN_IF_ERROR(RefuseDemoBeyondLoopback(its.store->people, page, link));
    Schools::Opened out;
    out.school = std::make_shared<School>(std::move(its.store), its.identity, school_options);
    out.school->services().page_url = PageUrlOf(row.hosts.front(), page, page_port);
    http::Monitoring monitoring{&out.school->metrics(), page.metrics_token};
    monitoring.budgets = [used = budgets_used, services = &out.school->services()] {
      return used(*services);
    };
    out.api = std::make_shared<http::Api>(out.school->store(), out.school->authenticator(),
                                          std::move(monitoring), page.store_threads,
                                          page.max_in_flight, page.deadlines.work, page.budgets);
    out.api->Show(out.school->live());
    out.api->Show(out.school->stations());
    BackupRun::Place backups = page.backups;
    backups.within = SchoolFolder({}, row.name);
    if (!backups.keyring.empty()) backups.keyring = SchoolFolder(backups.keyring, row.name);
    out.api->BackUpInto(std::move(backups));
    out.api->Enrol(its.identity.fingerprint.Hex());
    out.api->StationsListenAt(link_port);
    // The figures live as long as the school, and the Api as long as it, or a little less.
    out.school->metrics().Add([weak = std::weak_ptr(out.api)](ops::MetricsText& text) {
      if (const auto api = weak.lock()) api->AddFigures(text);
    });
    return out;
  }
};

}  // namespace

Status Serve(const ServeOptions& options) {
  // First, so that they go last: work still in a pool when the wait was cut short posts back to it.
  asio::io_context io;
  // Of its own: whatever strangers send to the page, chairs wait for no thread that reads it.
  asio::io_context link_io;
  StopSignals signals(io);
  ENAMEL_ASSIGN_OR_RETURN(Prepared prepared, Prepare(options));
  Store& store = *prepared.store;
  const ServerIdentity& identity = prepared.identity;
  http::HttpOptions& http_options = prepared.page;
  SchoolOptions school_options;
  school_options.auth.one_time_ms = UnixMs{options.one_time_password_days} * 24 * 60 * 60 * 1000;
  school_options.auth.hashing =
      std::make_shared<StorePool>(school_options.auth.hash_threads);  // one bound for all schools
  school_options.job_threads = options.job_threads;
  school_options.budgets = options.budgets;
  School school(std::move(prepared.store), identity, school_options);
  ENAMEL_ASSIGN_OR_RETURN(const bool has_admin, HasAdmin(store.people));
  auth::FirstAdmin first_admin;
  const bool gives_link = !has_admin && IsPrivate(http_options);
  if (gives_link) http_options.first_admin = &first_admin;
  http_options.metrics = &school.metrics();
  http_options.live = &school.live();
  http_options.stations = &school.stations();
  http_options.station_fingerprint = identity.fingerprint.Hex();
  const auto link_budget = std::make_shared<stations::LinkBudget>(options.budgets);
  prepared.link.budget = link_budget;
  http_options.budgets = options.budgets;
  http_options.bodies = std::make_shared<HeldBytes>(ops::LimitOf(ops::kBodies, options.budgets));
  const BudgetsUsed budgets_used = ServerBudgets(options.budgets, link_budget, http_options.bodies);
  http_options.budgets_used = [&] { return budgets_used(school.services()); };
  OpenOther other{options,      prepared.store_options, school_options,
                  http_options, prepared.link,          budgets_used};
  const auto forget_school = [&](const std::string& name) {
    if (Status gone = ForgetSchool(options.data, name); !gone.ok())
      spdlog::warn("{}", gone.message());
  };
  Peers peers(store, identity.fingerprint);
  if (store.shared) {
    http_options.peers = [&peers] { return peers.view(); };
    school.services().measure = [&store] { return MeasuredBy(store); };
  }
  Schools schools(
      store, [&](const SchoolRow& row) { return other.Open(row); }, forget_school);
  // Declared before what posts to it, hence destroyed after it; and what runs on it asks `schools`.
  StorePool pool(kStationThreads);
  http_options.other_schools = [&schools](const std::string& host) { return schools.AtHost(host); };
  http::HttpServer page(io, http_options, store, school.authenticator());
  stations::StationServer link(link_io, prepared.link, school.services(), pool, &schools);

  // The page first: with port 0 its address is known only now, and stations get it with their first
  // answer.
  ENAMEL_ASSIGN_OR_RETURN(other.page_port, page.Start());
  const std::string page_url =
      options.page_url.empty() && !options.host_names.empty()
          ? PageUrlOf(options.host_names.front(), http_options, other.page_port)
          : options.page_url;
  school.services().page_url = page_url;
  ENAMEL_ASSIGN_OR_RETURN(other.link_port, link.Start());
  page.StationsListenAt(other.link_port);
  const bool everywhere = asio::ip::make_address(prepared.link.address).is_unspecified();
  store.look.ListenAt(everywhere ? "" : prepared.link.address, other.link_port);
  school.Start();
  const auto pem = ReadFile(identity.certificate, size_t{1} << 20);
  if (const auto time =
          pem.ok() ? net::CertificateTimeOf(*pem) : Result<net::CertificateTime>(pem.status());
      time.ok()) {
    school.metrics().Add([until_ms = time->until_ms](ops::MetricsText& text) {
      ops::AddCertificate(text, "stations", until_ms);
    });
  }
  StoreWatch watch(store);
  schools.Begin();

  std::promise<void> stop_asked;
  const auto stop = [&] {
    signals.EndSoon();
    // First: an erasure that waits for another process would hold up every request behind it.
    store.StopWaiting();
    schools.StopWaiting();
    link.Stop();
    page.Stop();
    stop_asked.set_value();
  };
  asio::steady_timer drained(io);
  signals.OnFirst([&] {
    if (options.drain_s == 0) return stop();
    page.Drain();
    schools.Drain();
    spdlog::info("draining: /readyz answers 404; stopping in {} s", options.drain_s);
    drained.expires_after(std::chrono::seconds(options.drain_s));
    drained.async_wait([&](const boost::system::error_code&) { stop(); });
  });
  const net::Endpoint page_at{http_options.address, other.page_port};
  const net::Endpoint link_at{prepared.link.address, other.link_port};
  std::cout << "ready: page " << (http_options.tls ? "https://" : "http://") << page_at.Text()
            << ", stations " << link_at.Text() << ", fingerprint " << identity.fingerprint.Hex()
            << std::endl;
  if (gives_link) {
    const std::string local = (http_options.tls ? "https://" : "http://") + page_at.Text();
    SayFirstAdmin(page_url.empty() ? local : page_url, first_admin.Offer(enamel::UnixMs()));
  } else if (!has_admin) {
    spdlog::warn(
        "there is no admin, and the page has no TLS: add one on this machine with admin add-person "
        "--role admin");
  }

  if (RunUntilStopped({&io, &link_io}, options.io_threads, stop_asked.get_future()))
    signals.OnlyJobsRemain();
  // After the connections, since a seal that was just acknowledged may still queue a job. An
  // interrupted job begins again after the next start.
  school.StopJobs();
  spdlog::info("stopped");
  return Status::Ok();
}

}  // namespace enamel::server::app
