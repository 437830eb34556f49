#include "station/app/spool_command.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <boost/json.hpp>
#include <cstdio>
#include <ctime>
#include <initializer_list>
#include <string_view>

#include "common/base/counted.h"
#include "common/base/file.h"
#include "common/program/example.h"
#include "common/program/output.h"
#include "station/app/command_line.h"
#include "station/session/loop_facts.h"
#include "station/spool/salvage.h"
#include "station/spool/spool.h"
#include "station/spool/verify.h"
#include "station/uplink/attempt_sender.h"
#include "station/uplink/policy_file.h"

namespace enamel::station {
namespace {

namespace fs = std::filesystem;
namespace json = boost::json;
using unsigned_ll = unsigned long long;

constexpr char kLast[] = "last";

const char* StateOf(const SpooledAttempt& a) {
  if (!a.refused.empty()) return "refused";
  if (a.complete()) return "uploaded";
  return a.seal ? "waiting" : "unfinished";
}

// Why an attempt is not complete on the server, and since when; `tried_unix_ms` 0: unknown, or
// never.
struct Waiting {
  std::string why;  // empty: it does not wait
  int64_t since_unix_ms = 0, tried_unix_ms = 0;
};

Waiting WaitingOf(const SpooledAttempt& a) {
  // The most urgent for the person first.
  if (!a.refused.empty()) return {"the server refuses it: " + a.refused, a.refused_unix_ms, 0};
  if (a.waits() && !a.waits_because.empty()) {
    return {a.waits_because, a.waits_since_unix_ms, a.tried_unix_ms};
  }
  if (!a.seal) {
    return {"it has no end yet (interrupted, or still running): 'enamel-station run --resume " +
                a.id.Text() + "' resumes it, 'enamel-station spool close " + a.id.Text() +
                "' ends it where it stopped",
            0, 0};
  }
  if (a.waits()) {
    return {
        "nothing has tried to send it yet: the window does while it is open, and "
        "'enamel-station upload'",
        0, 0};
  }
  return {};
}

json::value WaitingFacts(const Waiting& waiting) {
  if (waiting.why.empty()) return nullptr;
  auto time = [](int64_t unix_ms) {
    return unix_ms == 0 ? json::value(nullptr) : json::value(unix_ms);
  };
  return json::object{{"why", waiting.why},
                      {"since_unix_ms", time(waiting.since_unix_ms)},
                      {"tried_unix_ms", time(waiting.tried_unix_ms)}};
}

json::object FactsOf(const SpooledAttempt& a) {
  json::object out{{"attempt_id", a.id.Text()},
                   {"state", StateOf(a)},
                   {"waits", WaitingFacts(WaitingOf(a))},
                   {"exercise", a.exercise},
                   {"profile", a.profile},
                   {"created_unix_ms", a.created_unix_ms},
                   {"ticks", a.ticks},
                   {"gap_ticks", a.gap_ticks},
                   {"chunks", a.chunks},
                   {"committed_chunks", a.committed},
                   {"bytes", a.bytes},
                   {"sealed", a.seal.has_value()},
                   {"refused", a.refused}};
  const json::value said = json::parse(protocol::FactsJson(a.facts));
  out.insert(said.as_object().begin(), said.as_object().end());
  return out;
}

// For reading. Null for a station that has recorded nothing yet.
Result<std::unique_ptr<Spool>> OpenSpool(const fs::path& data) {
  auto spool = Spool::OpenToRead(data);
  std::error_code error;
  bool enrolled = fs::exists(data / "station.json", error);
  // A station enrolled today is not broken; a folder of something else is.
  if (spool.status().code() == Code::kNotFound && enrolled) return std::unique_ptr<Spool>();
  return spool;
}

Result<std::vector<SpooledAttempt>> ListOf(const std::unique_ptr<Spool>& spool) {
  return spool ? spool->List() : std::vector<SpooledAttempt>();
}

// All the server's refusals in one sentence; ok if there are none.
Status Refusals(const std::vector<SpooledAttempt>& attempts) {
  const SpooledAttempt* first = nullptr;
  size_t count = 0;
  for (const SpooledAttempt& a : attempts) {
    if (a.refused.empty()) continue;
    if (count++ == 0) first = &a;
  }
  if (count == 0) return Status::Ok();
  std::string others = count == 1 ? "" : " (and " + std::to_string(count - 1) + " more)";
  return Status(Code::kForbidden,
                "the server refuses attempt " + first->id.Text() + others + ": " + first->refused +
                    ". It is kept here; when that is resolved, 'enamel-station spool upload "
                    "--again " +
                    first->id.Text() + "' sends it");
}

// The named attempt; for "last" the newest that `fits`.
Result<Uuid> AttemptMeant(Spool& spool, const std::string& text,
                          const std::function<bool(const SpooledAttempt&)>& fits) {
  if (text != kLast) return Uuid::Parse(text);
  ENAMEL_ASSIGN_OR_RETURN(auto all, spool.List());
  for (auto a = all.rbegin(); a != all.rend(); ++a) {
    if (fits(*a)) return a->id;
  }
  return Status(Code::kNotFound, "there is no such attempt in " + spool.file().string() +
                                     ": 'enamel-station spool list' shows those there are");
}

std::string LocalTime(int64_t unix_ms) {
  std::time_t t = unix_ms / 1000;
  std::tm local{};
  ::localtime_r(&t, &local);
  char text[32];
  std::strftime(text, sizeof text, "%Y-%m-%d %H:%M", &local);
  return text;
}

// "; since 2026-11-20 10:02, last tried 2026-11-20 10:40: the server is away"; empty if it does not
// wait.
std::string WaitingText(const Waiting& waiting) {
  if (waiting.why.empty()) return {};
  std::string when;
  if (waiting.since_unix_ms > 0) when = "since " + LocalTime(waiting.since_unix_ms);
  if (waiting.tried_unix_ms > 0) when += ", last tried " + LocalTime(waiting.tried_unix_ms);
  return "; " + when + (when.empty() ? "" : ": ") + waiting.why;
}

void PrintLine(const SpooledAttempt& a) {
  const std::string facts = protocol::FactsText(a.facts);
  std::printf("%s  %-10s  %s on %s  %llu ticks  %u of %u chunks on the server  %.1f kB  %s%s%s%s\n",
              a.id.Text().c_str(), StateOf(a), a.exercise.c_str(), a.profile.c_str(),
              static_cast<unsigned_ll>(a.ticks), a.committed, a.chunks,
              static_cast<double>(a.bytes) / 1000, LocalTime(a.created_unix_ms).c_str(),
              facts.empty() ? "" : "  ", facts.c_str(), WaitingText(WaitingOf(a)).c_str());
}

// A missing number reads as 0.
double NumberIn(const json::object& facts, std::initializer_list<std::string_view> path) {
  const json::object* at = &facts;
  const json::value* value = nullptr;
  for (std::string_view name : path) {
    value = at == nullptr ? nullptr : at->if_contains(name);
    at = value == nullptr ? nullptr : value->if_object();
  }
  if (value == nullptr) return 0;
  boost::system::error_code error;
  const double number = value->to_number<double>(error);
  return error ? 0 : number;
}

void PrintLoop(const KeptLoopFacts& run, const json::object& facts) {
  // From a newer program, or an older one: printed raw to avoid misreading it.
  if (NumberIn(facts, {"version"}) != kLoopFactsVersion) {
    std::printf("run %u, ended %s, in a version that this program does not know: %s\n", run.run,
                LocalTime(run.ended_unix_ms).c_str(), program::JsonText(facts).c_str());
    return;
  }
  std::printf(
      "run %u, ended %s: %.0f ticks, %.0f late, %.0f in gaps, %.0f interruptions, %.0f faults\n",
      run.run, LocalTime(run.ended_unix_ms).c_str(), NumberIn(facts, {"ticks"}),
      NumberIn(facts, {"late_ticks"}),
      NumberIn(facts, {"gap_ticks"}) + NumberIn(facts, {"skipped_ticks"}),
      NumberIn(facts, {"interruptions"}), NumberIn(facts, {"fault_count"}));
  for (const char* what : {"lateness", "tick"}) {
    std::printf("  %-8s  p50 %.1f  p99 %.1f  max %.1f us\n", what,
                NumberIn(facts, {what, "p50_us"}), NumberIn(facts, {what, "p99_us"}),
                NumberIn(facts, {what, "max_us"}));
  }
  const json::value* faults = facts.if_contains("faults");
  if (faults == nullptr || !faults->is_array()) return;
  for (const json::value& fault : faults->get_array()) {
    const json::object* record = fault.if_object();
    const json::value* why = record == nullptr ? nullptr : record->if_contains("why");
    if (why == nullptr || !why->is_string()) continue;
    std::printf("  fault at tick %.0f: %s\n", NumberIn(*record, {"tick"}),
                why->get_string().c_str());
  }
}

Status SendWaiting(AttemptSender& sender, Spool& spool, json::array& sent) {
  ENAMEL_ASSIGN_OR_RETURN(auto waiting, WaitingAttempts(spool));
  Status worst;
  for (const SpooledAttempt& attempt : waiting) {
    Status status = sender.Send(attempt.id);
    // A fault of the server or the way to it: the next attempt would meet the same. A fault of one
    // recording does not stop the others.
    if (!status.ok() && IsTransient(status) && !IsOfOneRecording(status)) {
      (void)spool.MarkAllTried(status.message());  // the link's error is the one to report
      return status;
    }
    ENAMEL_ASSIGN_OR_RETURN(auto after, spool.Get(attempt.id));
    sent.push_back(FactsOf(after));
    if (IsDamaged(status)) {
      worst = Status(
          status.code(),
          "attempt " + attempt.id.Text() +
              " cannot be sent whole, as not all of it can be read here: " + status.message(),
          status.field());
    } else if (!status.ok() && !IsDamaged(worst)) {
      worst = status;
    }
    std::printf("%s  %s  %u of %u chunks  %s\n", attempt.id.Text().c_str(), StateOf(after),
                after.committed, after.chunks, status.message().c_str());
    if (status.ok() && !after.seal) {
      std::printf("  it is kept here and on the server, and not scored: %s\n",
                  WaitingOf(after).why.c_str());
    }
  }
  return worst;
}

}  // namespace

Status ListSpool(const SpoolCommand& options) {
  ENAMEL_ASSIGN_OR_RETURN(auto spool, OpenSpool(options.workplace.data));
  const fs::path file = options.workplace.data / "spool.sqlite";
  ENAMEL_ASSIGN_OR_RETURN(auto attempts, ListOf(spool));
  uint64_t bytes = 0;
  for (const SpooledAttempt& a : attempts) bytes += a.bytes;
  if (!options.json.empty()) {
    json::array all;
    for (const SpooledAttempt& a : attempts) {
      ENAMEL_ASSIGN_OR_RETURN(auto last_ms, spool->LastSpooledUnixMs(a.id));
      json::object facts = FactsOf(a);
      if (last_ms) facts["last_spooled_unix_ms"] = *last_ms;
      all.push_back(std::move(facts));
    }
    ENAMEL_RETURN_IF_ERROR(program::WriteJsonFile(
        options.json, {{"spool", file.string()}, {"bytes", bytes}, {"attempts", all}}));
  }
  if (attempts.empty()) {
    std::printf("the spool %s is empty\n", file.c_str());
    return Status::Ok();
  }
  ENAMEL_ASSIGN_OR_RETURN(auto waiting, WaitingAttempts(*spool));
  auto refused =
      std::ranges::count_if(attempts, [](const SpooledAttempt& a) { return !a.refused.empty(); });
  std::printf("%s: %s, %.1f MB; %zu with something the server does not have%s\n", file.c_str(),
              Counted(attempts.size(), "attempt").c_str(), static_cast<double>(bytes) / 1e6,
              waiting.size(),
              refused == 0 ? "" : (", " + std::to_string(refused) + " that it refuses").c_str());
  for (const SpooledAttempt& a : attempts) PrintLine(a);
  return Status::Ok();
}

Status ShowLoops(const SpoolCommand& options) {
  ENAMEL_ASSIGN_OR_RETURN(auto spool, Spool::OpenToRead(options.workplace.data));
  auto id = AttemptMeant(*spool, options.attempt, [](const auto&) { return true; });
  ENAMEL_RETURN_IF_ERROR(id.status());
  if (auto there = spool->Get(*id); !there.ok()) return there.status();
  ENAMEL_ASSIGN_OR_RETURN(auto kept, spool->loop_facts().Of(*id));
  json::array runs;
  for (const KeptLoopFacts& run : kept) {
    boost::system::error_code error;
    json::value facts = json::parse(run.json, error);
    if (error || !facts.is_object()) {
      return Status(Code::kStorage, "how run " + std::to_string(run.run) + " of attempt " +
                                        id->Text() +
                                        " went is not kept as JSON: the spool is damaged, "
                                        "'enamel-station spool verify' says how far");
    }
    PrintLoop(run, facts.as_object());
    runs.push_back(
        {{"run", run.run}, {"ended_unix_ms", run.ended_unix_ms}, {"facts", std::move(facts)}});
  }
  if (runs.empty()) {
    std::printf("%s: no loop of it ran to its end (still running, or interrupted)\n",
                id->Text().c_str());
  }
  return program::WriteJsonFile(options.json, {{"attempt_id", id->Text()}, {"runs", runs}});
}

Status VerifySpool(const SpoolCommand& options) {
  ENAMEL_ASSIGN_OR_RETURN(auto spool, OpenSpool(options.workplace.data));
  std::optional<trace::PublicKey> key;
  if (auto credentials = LoadCredentials(options.workplace.data); credentials.ok()) {
    // The spool was copied away: signatures are not checked, and the output notes that.
    key = credentials->public_key();
  }
  Status pages;
  ENAMEL_ASSIGN_OR_RETURN(auto verdicts,
                          spool ? VerifyRecordings(*spool, key, &pages)
                                : Result<std::vector<SpoolVerdict>>(std::vector<SpoolVerdict>()));
  Status worst = pages;
  json::array all;
  for (const SpoolVerdict& v : verdicts) {
    json::object facts = FactsOf(v.attempt);
    facts["whole"] = v.status.ok();
    facts["problem"] = v.status.message();
    all.push_back(facts);
    std::printf("%s  %s\n", v.attempt.id.Text().c_str(),
                v.status.ok() ? "whole" : v.status.message().c_str());
    if (!v.status.ok()) {
      worst = Status(v.status.code(), "attempt " + v.attempt.id.Text() + ": " + v.status.message());
    }
  }
  ENAMEL_RETURN_IF_ERROR(program::WriteJsonFile(
      options.json, {{"signatures_checked", key.has_value()}, {"attempts", all}}));
  if (worst.ok()) {
    std::printf("%zu attempts: chains%s and seals are right\n", verdicts.size(),
                key ? ", signatures" : "");
  }
  return worst;
}

Status ExportFromSpool(const SpoolCommand& options) {
  ENAMEL_RETURN_IF_ERROR(program::CheckOutputFile(options.out, "--out"));
  ENAMEL_ASSIGN_OR_RETURN(auto spool, Spool::OpenToRead(options.workplace.data));
  auto id = AttemptMeant(*spool, options.attempt, [](const auto&) { return true; });
  ENAMEL_RETURN_IF_ERROR(id.status());
  ENAMEL_ASSIGN_OR_RETURN(auto file, spool->Export(*id));
  Bytes bytes = trace::EncodeTraceFile(file);
  // Only for this user: a recording is personal data (schemas/personal_data.md).
  ENAMEL_RETURN_IF_ERROR(WriteFileDurably(options.out, bytes, 0600));
  ENAMEL_RETURN_IF_ERROR(program::WriteJsonFile(options.json, {{"attempt_id", id->Text()},
                                                               {"file", options.out.string()},
                                                               {"chunks", file.chunks.size()},
                                                               {"bytes", bytes.size()},
                                                               {"sealed", file.seal.has_value()}}));
  std::printf("%s: %zu chunks, %zu bytes%s\n", options.out.c_str(), file.chunks.size(),
              bytes.size(), file.seal ? ", sealed" : ", not sealed");
  return Status::Ok();
}

Status UploadSpool(const SpoolCommand& options) {
  ENAMEL_ASSIGN_OR_RETURN(auto credentials,
                          LoadCredentialsFor(options.workplace.data, options.workplace.server));
  ENAMEL_ASSIGN_OR_RETURN(auto spool, Spool::Open(options.workplace.data));
  if (!options.again.empty()) {
    ENAMEL_ASSIGN_OR_RETURN(auto id, Uuid::Parse(options.again));
    ENAMEL_ASSIGN_OR_RETURN(auto there, spool->Get(id));
    ENAMEL_RETURN_IF_ERROR(spool->ClearRefusal(id));
  }
  ENAMEL_ASSIGN_OR_RETURN(auto waiting, WaitingAttempts(*spool));
  ServerLink link;
  Bandwidth bandwidth(options.workplace.uploader.bytes_per_s);
  AttemptSender sender(link, *spool, bandwidth);
  Status status = link.Connect(credentials);
  if (status.ok()) {
    KeepPolicy(options.workplace.data, link.policy());
    // First asks what the server has lost: only then is it known what to send.
    auto wanted = sender.Offer();
    status = wanted.ok() ? sender.ReturnTickets() : wanted.status();
    if (wanted.ok() && *wanted > 0) {
      std::printf("the server has lost %zu attempts that it once had: they are sent again\n",
                  *wanted);
    }
  } else if (waiting.empty() && IsTransient(status)) {
    status = Status::Ok();  // nothing to send, and nobody to ask about losses
  }
  if (!status.ok() && !IsDamaged(status)) (void)(spool)->MarkAllTried(status.message());
  json::array sent;
  if (status.ok() && link.connected()) status = SendWaiting(sender, *spool, sent);
  // While the server is away, an earlier refusal may be outdated: it is reported when the server
  // answers again.
  if (status.ok() || !IsTransient(status)) {
    ENAMEL_ASSIGN_OR_RETURN(auto all, spool->List());
    if (Status refused = Refusals(all); !refused.ok()) status = refused;
  }
  // After sending, so that recordings just found missing are not deleted.
  ENAMEL_ASSIGN_OR_RETURN(auto pruned, spool->Prune(options.workplace.retention));
  if (std::string text = PrunedText(pruned, options.workplace.retention); !text.empty()) {
    spdlog::warn("{}", text);
  }
  ENAMEL_RETURN_IF_ERROR(
      program::WriteJsonFile(options.json, {{"attempts", sent}, {"problem", status.message()}}));
  if (status.ok() && sent.empty()) std::printf("nothing to upload\n");
  return status;
}

Status SalvageIntoFolder(const SpoolCommand& options) {
  ENAMEL_ASSIGN_OR_RETURN(auto saved, SalvageSpool(options.workplace.data, options.out));
  json::array all;
  size_t hit = 0;
  for (const SalvagedAttempt& a : saved.attempts) {
    hit += a.problem.ok() ? 0 : 1;
    all.push_back({{"attempt_id", a.id.Text()},
                   {"chunks", a.chunks},
                   {"expected_chunks", a.expected},
                   {"sealed", a.sealed},
                   {"problem", a.problem.message()}});
    std::printf("%s  %u of %u chunks saved%s%s\n", a.id.Text().c_str(), a.chunks, a.expected,
                a.problem.ok() ? "" : ": ", a.problem.message().c_str());
  }
  ENAMEL_RETURN_IF_ERROR(program::WriteJsonFile(
      options.json, {{"attempts", all}, {"hit", hit}, {"tickets", saved.tickets}}));
  std::printf(
      "%zu attempts whole, %zu hit, %zu tickets for later. The new spool is %s: move the damaged "
      "one away (keep it) with what is beside it (-wal, -shm), and this one into its place\n",
      saved.attempts.size() - hit, hit, saved.tickets, (options.out / "spool.sqlite").c_str());
  return Status::Ok();
}

Status CloseInSpool(const SpoolCommand& options) {
  ENAMEL_ASSIGN_OR_RETURN(auto spool, Spool::Open(options.workplace.data));
  // A window may be recording this very attempt, which must not be ended meanwhile.
  ENAMEL_ASSIGN_OR_RETURN(auto lock, spool->LockForRecording());
  auto id = AttemptMeant(*spool, options.attempt, [](const auto& a) { return !a.seal; });
  ENAMEL_RETURN_IF_ERROR(id.status());
  ENAMEL_ASSIGN_OR_RETURN(auto seal, spool->CloseAttempt(*id));
  ENAMEL_RETURN_IF_ERROR(program::WriteJsonFile(
      options.json, {{"attempt_id", id->Text()}, {"chunks", seal.chunks}, {"ticks", seal.ticks}}));
  std::printf(
      "%s: sealed after %llu ticks; what was not cut counts as missing. 'enamel-station upload' "
      "sends it\n",
      id->Text().c_str(), static_cast<unsigned_ll>(seal.ticks));
  return Status::Ok();
}

void DeclareSpool(CommandGroup group) {
  auto options = std::make_shared<SpoolCommand>();
  auto add = [&](CLI::App& to, const char* name, const char* about,
                 Status (*command)(const SpoolCommand&)) {
    CLI::App* added = to.add_subcommand(name, about);
    // The same command is available under `spool` and at the top, where the window's advice names
    // it.
    if (command == UploadSpool) {
      AddWorkplaceSettings(*added, group.place);
      added->add_option("--again", options->again,
                        "Id of a recording that the server refused: it is tried once more");
    } else {
      AddDataOption(*added, group.place);
    }
    added->add_option("--json", options->json, "Write the facts to this file");
    added->callback([options, group, command] {
      options->workplace = group.place.Options();
      const Status can_write = program::CheckOutputFile(options->json, "--json");
      group.exit_code = Finish(can_write.ok() ? command(*options) : can_write);
    });
    return added;
  };
  constexpr char kUpload[] = "Send recordings that the server does not have, or has lost";
  program::AddExamples(*add(group.app, "upload", kUpload, UploadSpool), {""});
  CLI::App* spool = group.app.add_subcommand("spool", "Recordings on this station");
  spool->require_subcommand(1);
  program::AddExamples(
      *add(*spool, "list", "List recordings, their size, and what keeps them from the server",
           ListSpool),
      {""});
  program::AddExamples(
      *add(*spool, "verify", "Check pages, chains, signatures and seals", VerifySpool), {""});
  program::AddExamples(*add(*spool, "upload", kUpload, UploadSpool),
                       {"", "--again 6f1c9a52-3d0e-4b7a-9c41-2f8d5e07a613"});
  auto* salvage = add(*spool, "salvage", "Save what can be read of a damaged spool into a new one",
                      SalvageIntoFolder);
  salvage->add_option("--out", options->out, "Folder for the new spool; it must not have one yet")
      ->required();
  program::AddExamples(*salvage, {"--out /var/lib/enamel-station/saved"});
  auto with_attempt = [&](CLI::App* command) {
    command->add_option("attempt", options->attempt, "Its id, as 'spool list' prints it, or 'last'")
        ->required();
    return command;
  };
  auto* to_file =
      with_attempt(add(*spool, "export", "Write one recording to a file", ExportFromSpool));
  to_file->add_option("--out", options->out, "File to write")->required();
  program::AddExamples(*to_file, {"last --out last.entrace"});
  program::AddExamples(
      *with_attempt(add(*spool, "loops",
                        "Show how punctual the haptic loop of an attempt was, and its faults",
                        ShowLoops)),
      {"last"});
  program::AddExamples(
      *with_attempt(add(*spool, "close",
                        "End an attempt that was cut off, so that it is scored as far as it goes",
                        CloseInSpool)),
      {"last"});
  program::AddExamples(*spool, {"list"});
}

}  // namespace enamel::station
