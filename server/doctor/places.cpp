#include <algorithm>
#include <cmath>
#include <string>

#include "common/base/unix_time.h"
#include "common/net/web_question.h"
#include "server/doctor/doctor.h"
#include "server/postgres/pg_db.h"
#include "server/storage/engine/database.h"
#include "server/storage/engine/pg_database.h"
#include "server/storage/folder/database_file.h"
#include "server/storage/keys/key_bucket.h"
#include "server/storage/keys/master_key.h"
#include "server/training/ticket_rules.h"

// The places of a school: its database and its S3 stores.
namespace enamel::server::app::examined {

using program::Finding;
using program::Verdict;

namespace {

constexpr int kPostgres15 = 150000;
// docs/several_servers.md: of each school and server, and a command beside it.
constexpr int64_t kConnections = 8;
constexpr int64_t kMaxClockOffMs = 1000;

Finding OfHost(const sql::PgHost& host) {
  const std::string what = "database " + host.where;
  if (!host.problem.empty()) {
    return {what, Verdict::kWarn, host.problem, PgRemedy(host.kind)};
  }
  std::string found = (host.takes_writes ? "the primary" : "a standby") +
                      std::string(", version ") + std::to_string(host.version / 10000) + "." +
                      std::to_string(host.version % 10000) + (host.tls ? ", over TLS" : "");
  if (host.version < kPostgres15) {
    return {what, Verdict::kFail, found, "PostgreSQL 15 or newer is needed"};
  }
  if (host.certificate_until_ms == 0) return {what, Verdict::kOk, found, ""};
  Finding out = Dates(what, host.certificate_until_ms, "renew the database server's certificate");
  out.found = found + ", certificate " + out.found;
  return out;
}

void OfPrimaries(const std::vector<sql::PgHost>& hosts, Findings& out) {
  std::vector<sql::PgHost> primaries;
  std::ranges::copy_if(hosts, std::back_inserter(primaries), &sql::PgHost::takes_writes);
  if (primaries.empty()) {
    out.push_back({"database", Verdict::kFail, "none of its servers takes writes",
                   "start the primary, or promote a standby"});
  }
  // One host under several addresses has one timeline.
  for (const sql::PgHost& one : primaries) {
    if (one.timeline == primaries.front().timeline) continue;
    out.push_back(
        {"database", Verdict::kFail,
         primaries.front().where + " and " + one.where + " both take writes",
         "stop the one that was promoted first: " +
             (one.timeline < primaries.front().timeline ? one.where : primaries.front().where)});
  }
}

Finding OfStandby(sql::Standby standby) {
  const std::string what = "standby";
  switch (standby) {
    case sql::Standby::kSynchronous:
      return {what, Verdict::kOk, "every commit waits until a standby has it", ""};
    case sql::Standby::kMissing:
      return {what, Verdict::kFail, "every change waits: too few standbys are connected",
              "start the standbys in synchronous_standby_names, or remove the setting"};
    case sql::Standby::kBehind:
      return {what, Verdict::kWarn, "a standby follows, and may lack the last commits",
              "set synchronous_standby_names on the primary"};
    case sql::Standby::kNone:
      return {what, Verdict::kWarn, "there is none: commits are on one disk",
              "set one up; docs/several_servers.md, \"PostgreSQL failover\""};
    default:
      return {what, Verdict::kWarn, "not shown to this user",
              "as postgres: psql -c 'GRANT pg_monitor TO ' and the user's name"};
  }
}

void OfSettings(const PgFacts& facts, Findings& out) {
  out.push_back({"database role", facts.superuser ? Verdict::kWarn : Verdict::kOk,
                 facts.superuser ? "it is a superuser of the database server" : "no superuser",
                 facts.superuser ? "use one that owns the database and nothing else" : ""});
  if (!facts.durable) {
    out.push_back({"database settings", Verdict::kFail,
                   "fsync or full_page_writes is off: a power cut can lose or damage everything",
                   "turn both on"});
  }
  const bool few = facts.most_connections - facts.connections < kConnections;
  out.push_back({"connections", few ? Verdict::kWarn : Verdict::kOk,
                 std::to_string(facts.connections) + " of " +
                     std::to_string(facts.most_connections) + " are used",
                 few ? "raise max_connections: each school and server takes up to 8" : ""});
}

void OfClock(sql::Db& db, Findings& out) {
  const UnixMs asked = enamel::UnixMs();
  const auto theirs = db.ClockMs();
  if (!theirs.ok() || !*theirs) return;
  const UnixMs off = **theirs - (asked + enamel::UnixMs()) / 2;
  const bool right = std::abs(off) <= kMaxClockOffMs;
  out.push_back({"database clock", right ? Verdict::kOk : Verdict::kWarn,
                 std::to_string(std::abs(off)) + " ms " + (off < 0 ? "behind" : "ahead of") +
                     " this machine's",
                 right ? "" : "let both keep the time of the same time servers"});
}

void OfSchema(int version, Findings& out) {
  const int newest = LatestSchemaVersion();
  const std::string found = "version " + std::to_string(version);
  if (version == newest) return out.push_back({"schema", Verdict::kOk, found, ""});
  if (version < newest) {
    return out.push_back({"schema", Verdict::kWarn, found + ", this program's is newer",
                          "make a backup and restart the server: it migrates"});
  }
  out.push_back({"schema", Verdict::kFail, found + " is newer than this program",
                 "install the version that the other servers have"});
}

void Postgres(const DatabaseFile& file, Findings& out) {
  sql::PgDbOptions options;
  options.server = file.server;
  const auto hosts = sql::PgDb::Hosts(options);
  if (!hosts.ok()) {
    out.push_back({"database", Verdict::kFail, hosts.status().message(), ""});
    return;
  }
  for (const sql::PgHost& host : *hosts) out.push_back(OfHost(host));
  OfPrimaries(*hosts, out);
  const auto db = OpenPgDatabase(file.server, file.schema, /*read_only=*/true, {});
  if (!db.ok()) {
    out.push_back({"database", Verdict::kFail, db.status().message(), ""});
    return;
  }
  if (const auto version = SchemaVersion(**db); version.ok()) OfSchema(*version, out);
  if (const auto facts = ReadPgFacts(**db); facts.ok()) OfSettings(*facts, out);
  if (const auto standby = (*db)->StandbyOf(); standby.ok()) out.push_back(OfStandby(*standby));
  OfClock(**db, out);
}

}  // namespace

void Database(const ServeOptions& serve, Findings& out) {
  const auto file = ReadDatabaseFile(serve.data);
  if (!file.ok()) {
    out.push_back({"database", Verdict::kFail, file.status().message(), ""});
    return;
  }
  if (*file) return Postgres(**file, out);
  const auto path = serve.data / "enamel.db";
  std::error_code error;
  if (!std::filesystem::exists(path, error)) {
    out.push_back(
        {"database", Verdict::kWarn, "there is none yet", "the server makes it when it starts"});
    return;
  }
  const auto db = OpenDatabase(path, DbMode::kReadOnly);
  const auto version = db.ok() ? SchemaVersion(**db) : Result<int>(db.status());
  if (!version.ok()) {
    out.push_back({"database", Verdict::kFail, version.status().message(),
                   "stop the server, and enamel-server verify lists what is damaged"});
    return;
  }
  out.push_back({"database", Verdict::kOk, "in the folder (SQLite)", ""});
  OfSchema(*version, out);
}

namespace {

// What a bucket's store shows by itself.
void OfStore(const std::string& what, const PlaceInS3& place, Findings& out) {
  constexpr std::string_view kTls = "https://";
  if (!place.endpoint.starts_with(kTls)) return;
  std::string host = place.endpoint.substr(kTls.size());
  host = host.substr(0, host.find('/'));
  net::WebQuestion question;
  const size_t colon = host.rfind(':');
  question.host = host.substr(0, colon);
  if (colon != std::string::npos)
    question.port = static_cast<uint16_t>(std::strtoul(host.c_str() + colon + 1, nullptr, 10));
  question.ca_file = place.ca_file;
  const auto answer = net::Ask(question);
  if (!answer.ok() || !answer->certificate) return;
  out.push_back(
      Dates(what + "'s TLS", answer->certificate->until_ms, "renew the store's certificate"));
}

}  // namespace

void Buckets(const ServeOptions& serve, Findings& out) {
  const auto file = ReadDatabaseFile(serve.data);
  if (!file.ok() || !*file) return;
  const auto failed = [&](const std::string& what, const Status& status) {
    out.push_back({what, Verdict::kFail, status.message(), ""});
  };
  if (const auto& blobs = (*file)->blobs) {
    const auto place = ReadS3Place(serve.data, *blobs);
    const Status tried = place.ok() ? TryS3Place(*place) : place.status();
    if (!tried.ok()) failed("bucket of blobs", tried);
    if (tried.ok()) {
      out.push_back(
          {"bucket of blobs", Verdict::kOk, "written, read and deleted in " + blobs->bucket, ""});
    }
    OfStore("bucket of blobs", *blobs, out);
  }
  if (const auto& keys = (*file)->keys) {
    const auto place = ReadKeyBucket(serve.data, *keys);
    Status tried = place.ok() ? TryS3Place(place->place) : place.status();
    if (tried.ok()) {
      const auto bucket = s3::S3Client::Make(place->place.store);
      tried = bucket.ok() ? MustForgetWhatIsDeleted(**bucket) : bucket.status();
    }
    if (!tried.ok()) failed("bucket of keys", tried);
    if (tried.ok()) {
      out.push_back(
          {"bucket of keys", Verdict::kOk,
           "written, read and deleted in " + keys->bucket.bucket + ", which keeps no versions",
           ""});
    }
    if (place.ok()) {
      const auto master = ReadMasterKey(place->master_key);
      if (!master.ok()) failed("master key", master.status());
    }
  }
}

}  // namespace enamel::server::app::examined
