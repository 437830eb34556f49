#include "server/commands/personal_data.h"

#include <boost/json.hpp>

#include "common/base/counted.h"
#include "common/base/file.h"
#include "common/program/output.h"
#include "server/app/data_folder.h"
#include "server/commands/admin.h"
#include "server/commands/command_line.h"
#include "server/commands/say.h"
#include "server/http/views/attempt_view.h"
#include "server/http/views/audit_view.h"
#include "server/jobs/result_package.h"
#include "server/jobs/stored_tooth.h"
#include "server/storage/attempts/attempt_rows.h"
#include "server/storage/audit/audit_rows.h"
#include "server/storage/people/session_rows.h"
#include "server/storage/store.h"

namespace enamel::server::app {
namespace {

namespace fs = std::filesystem;
namespace json = boost::json;

// Collects an export's files and their entries in export.json.
class Exporter {
 public:
  Exporter(Store& store, fs::path target) : store_(store), target_(std::move(target)) {}

  Status Run(const Person& person) {
    ENAMEL_RETURN_IF_ERROR(MakeFolder(target_));
    json::object root{{"format", "enamel-person"},
                      {"version", 1},
                      {"person",
                       {{"id", person.id.Text()},
                        {"login", person.login},
                        {"display_name", person.display_name},
                        {"role", RoleName(person.role)},
                        {"disabled", person.disabled},
                        {"created_ms", person.created_ms},
                        {"language", person.language}}}};
    // export.json last: if it exists, so do the files it names.
    ENAMEL_RETURN_IF_ERROR(AddCohorts(person, root));
    ENAMEL_RETURN_IF_ERROR(AddSessions(person, root));
    ENAMEL_RETURN_IF_ERROR(AddSavedTexts(person, root));
    ENAMEL_RETURN_IF_ERROR(AddAttempts(person, root));
    ENAMEL_RETURN_IF_ERROR(AddAudit(person, root));
    return Write("export.json", AsBytes(program::JsonText(root) + "\n"));
  }
  size_t attempts() const { return attempts_; }
  uint64_t bytes() const { return bytes_; }

 private:
  static Status MakeFolder(const fs::path& folder) {
    std::error_code error;
    fs::create_directories(folder, error);
    if (!error) fs::permissions(folder, fs::perms::owner_all, error);
    if (!error) return Status::Ok();
    return Status(Code::kStorage, "cannot make " + folder.string() + ": " + error.message());
  }

  Status Write(const fs::path& name, ByteView content) {
    bytes_ += content.size();
    return WriteFileDurably(target_ / name, content, 0600);
  }

  Status AddCohorts(const Person& person, json::object& root) {
    ENAMEL_ASSIGN_OR_RETURN(auto cohorts, store_.cohorts.CohortsOf(person.id));
    json::array names;
    for (const Cohort& cohort : cohorts) names.emplace_back(cohort.name);
    root["cohorts"] = std::move(names);
    return Status::Ok();
  }

  Status AddSessions(const Person& person, json::object& root) {
    ENAMEL_ASSIGN_OR_RETURN(auto rows, store_.sessions.SessionsOf(person.id));
    json::array sessions;
    for (const SessionRow& row : rows) {
      sessions.push_back({{"via", row.via},
                          {"address", row.address},
                          {"device", row.device},
                          {"created_ms", row.created_ms},
                          {"last_used_ms", row.last_used_ms}});
    }
    root["sessions"] = std::move(sessions);
    return Status::Ok();
  }

  Status AddSavedTexts(const Person& person, json::object& root) {
    ENAMEL_ASSIGN_OR_RETURN(auto rows, store_.saved_texts.SavedTexts(person.id));
    json::array texts;
    for (const SavedText& row : rows) {
      if (row.owner != person.id) continue;
      texts.push_back({{"text", row.text}, {"shared", row.shared}, {"saved_ms", row.saved_ms}});
    }
    root["saved_texts"] = std::move(texts);
    return Status::Ok();
  }

  Status AddAudit(const Person& person, json::object& root) {
    // Actions by the person and on the person: both are data about them.
    ENAMEL_ASSIGN_OR_RETURN(auto rows, store_.audit.AuditAbout(person.id));
    json::array audit;
    for (const AuditRow& row : rows) audit.push_back(http::AuditJson(row));
    root["audit"] = std::move(audit);
    return Status::Ok();
  }

  Status AddAttempts(const Person& person, json::object& root) {
    AttemptFilter filter;
    filter.person = person.id;
    filter.limit = 200;
    json::array attempts;
    for (;;) {
      ENAMEL_ASSIGN_OR_RETURN(auto rows, store_.attempts.Attempts(filter));
      for (const AttemptRow& row : rows) {
        json::object facts = Facts(row);
        ENAMEL_RETURN_IF_ERROR(AddOverride(row, facts));
        ENAMEL_RETURN_IF_ERROR(AddWords(row, facts));
        ENAMEL_RETURN_IF_ERROR(AddFiles(row, facts));
        attempts.push_back(std::move(facts));
        ++attempts_;
      }
      if (rows.size() < filter.limit) break;
      filter.before = rows.back().id;
    }
    root["attempts"] = std::move(attempts);
    return Status::Ok();
  }

  static json::object Facts(const AttemptRow& row) {
    json::object out{{"id", row.id.Text()},
                     {"exercise", row.exercise_title},
                     {"station", row.station.Text()},
                     {"state", AttemptStateName(row.state)},
                     {"as_reference", row.as_reference},
                     {"released", row.released},
                     {"ticketed_ms", row.ticketed_ms},
                     {"sealed_ms", row.sealed_ms},
                     {"recording_removed_ms", row.expired_ms},
                     {"ticks", row.ticks},
                     {"gap_ticks", row.gap_ticks},
                     {"problem", row.problem}};
    if (row.score) out["score"] = *row.score;
    out["exam"] = row.exam;
    out["due_ms"] = row.due_ms;
    json::array flags;
    for (const char* flag : AttemptFlagNames(row.flags)) flags.emplace_back(flag);
    out["flags"] = std::move(flags);
    out["facts"] = json::parse(row.facts);
    out["hand"] = http::HandJson(row.hand);
    return out;
  }

  // Who said something, as the page names them.
  Result<std::string> NameOf(const Uuid& author) {
    if (author.IsZero()) return std::string("command line");
    auto person = store_.people.PersonById(author);
    if (person.ok()) return person->display_name;
    if (person.status().code() == Code::kNotFound) return std::string();
    return person.status();
  }

  Status AddOverride(const AttemptRow& row, json::object& facts) {
    if (!row.overridden) return Status::Ok();
    ENAMEL_ASSIGN_OR_RETURN(auto by, NameOf(row.overridden->by));
    facts["override"] = {{"score", row.overridden->score},
                         {"reason", row.overridden->reason},
                         {"by", by},
                         {"at_ms", row.overridden->at_ms}};
    return Status::Ok();
  }

  // Every run, newest first; earlier ones' reasons as files.
  Status AddResults(const AttemptRow& row, json::object& facts, json::array& files,
                    json::array& problems) {
    ENAMEL_ASSIGN_OR_RETURN(auto results, store_.results.ResultsOf(row.id));
    json::array out;
    for (const ResultRow& result : results) {
      out.push_back({{"run", result.run},
                     {"scored_ms", result.scored_ms},
                     {"cause", result.cause},
                     {"score", result.score},
                     {"critical_fail", result.critical_fail}});
      if (&result == &results.front()) continue;  // score.json
      std::string name = "score_" + std::to_string(result.run) + ".json";
      ENAMEL_RETURN_IF_ERROR(
          AddFile(row, name, InOnePiece(store_.blobs.GetBlob(result.score_json)), files, problems));
    }
    facts["results"] = std::move(out);
    return Status::Ok();
  }

  // What cannot be read is said in the export, and does not end it.
  Status AddFile(const AttemptRow& row, const std::string& name, const Result<BytePieces>& content,
                 json::array& files, json::array& problems) {
    fs::path path = fs::path("attempts") / row.id.Text() / name;
    // Only failures to read are noted in the export. A full disk under the export ends it.
    Status unread = content.status();
    BytePieces pieces;
    if (content.ok()) {
      pieces = *content;
      pieces.next = [&unread, next = content->next]() -> Result<Bytes> {
        auto piece = next();
        if (!piece.ok()) unread = piece.status();
        return piece;
      };
      const Status written = WriteFileDurably(target_ / path, pieces, 0600);
      if (unread.ok()) ENAMEL_RETURN_IF_ERROR(written);
    }
    if (!unread.ok()) {
      problems.emplace_back(name + ": " + unread.message());
      return Status::Ok();
    }
    bytes_ += pieces.size;
    files.emplace_back(path.generic_string());
    return Status::Ok();
  }

  // Remarks, signatures and appeals about it.
  Status AddWords(const AttemptRow& row, json::object& facts) {
    ENAMEL_ASSIGN_OR_RETURN(auto remarks, store_.remarks.AnnotationsOf(row.id));
    json::array annotations;
    for (const AnnotationRow& remark : remarks) {
      ENAMEL_ASSIGN_OR_RETURN(auto by, NameOf(remark.author));
      annotations.push_back({{"tick", remark.tick},
                             {"text", remark.text},
                             {"to_chair", remark.to_chair},
                             {"by", by},
                             {"created_ms", remark.created_ms}});
    }
    facts["annotations"] = std::move(annotations);
    ENAMEL_ASSIGN_OR_RETURN(const auto signatures, store_.sign_offs.SignOffsOf(row.id));
    json::array sign_offs;
    for (const SignOffRow& each : signatures) {
      sign_offs.push_back(
          {{"at", SignedAtName(each.at)}, {"by", each.signer_name}, {"signed_ms", each.signed_ms}});
    }
    facts["sign_offs"] = std::move(sign_offs);
    ENAMEL_ASSIGN_OR_RETURN(auto appeal, store_.appeals.AppealOf(row.id));
    if (!appeal) return Status::Ok();
    facts["appeal"] = {{"filed_ms", appeal->filed_ms},
                       {"text", appeal->text},
                       {"state", appeal->state},
                       {"answer", appeal->answer},
                       {"answered_ms", appeal->answered_ms}};
    if (appeal->answered_ms == 0) return Status::Ok();
    ENAMEL_ASSIGN_OR_RETURN(auto by, NameOf(appeal->answered_by));
    facts["appeal"].as_object()["answered_by"] = by;
    return Status::Ok();
  }

  Status AddFiles(const AttemptRow& row, json::object& facts) {
    json::array files, problems;
    ENAMEL_RETURN_IF_ERROR(MakeFolder(target_ / "attempts" / row.id.Text()));
    auto add = [&](std::string_view name, const Result<BytePieces>& content) {
      return AddFile(row, std::string(name), content, files, problems);
    };
    // Neither is missing: one was not begun, the other's recording was removed by a rule, which
    // `recording_removed_ms` says.
    const bool has_recording = row.state != AttemptState::kTicketed && row.expired_ms == 0;
    if (row.score) {
      const auto surface = [&](const AttemptResult& result) {
        return AttemptSurface(store_.blobs, result);
      };
      ENAMEL_RETURN_IF_ERROR(ForEachResultFile(store_, row, surface, add));
    } else if (has_recording) {
      ENAMEL_RETURN_IF_ERROR(add("recording.entrace", TraceFileOf(store_, row)));
    }
    ENAMEL_RETURN_IF_ERROR(AddResults(row, facts, files, problems));
    facts["files"] = std::move(files);
    if (!problems.empty()) facts["problems"] = std::move(problems);
    return Status::Ok();
  }

  Store& store_;
  const fs::path target_;
  size_t attempts_ = 0;
  uint64_t bytes_ = 0;
};

}  // namespace

Status ExportPerson(const fs::path& data, const std::string& login, const fs::path& target) {
  std::error_code error;
  // A folder that holds an older export would mix two moments, or two people.
  if (fs::exists(target, error) && !fs::is_empty(target, error)) {
    return Status(Code::kConflict,
                  "expected an absent or empty folder for the export, found files in " +
                      target.string() + "; name another one");
  }
  ENAMEL_ASSIGN_OR_RETURN(auto store, OpenForCommand(data));
  ENAMEL_ASSIGN_OR_RETURN(auto person, PersonNamed(store->people, login));
  Exporter exporter(*store, target);
  ENAMEL_RETURN_IF_ERROR(exporter.Run(person));
  // After it has succeeded, and into the person's own trail: the next export shows this one.
  ENAMEL_RETURN_IF_ERROR(
      store->audit.NoteAudit(kCommandLine, "person.export", person.id.Text(), "{}"));
  Say("{}: {}, {} in {}\n", login, Counted(exporter.attempts(), "attempt"),
      Counted(exporter.bytes(), "byte"), target.string());
  return Status::Ok();
}

Status ErasePerson(const fs::path& data, const std::string& login, const std::string& confirm,
                   bool with_references) {
  // Compared as typed: a line from the shell's history, changed in one place alone, erases nobody.
  if (confirm != login) {
    return Status(
        Code::kInvalidInput,
        "erasing cannot be undone: expected --confirm " + login + ", found \"" + confirm + "\"",
        "confirm");
  }
  ENAMEL_ASSIGN_OR_RETURN(auto store, OpenForCommand(data));
  ENAMEL_ASSIGN_OR_RETURN(auto person, PersonNamed(store->people, login));
  ENAMEL_ASSIGN_OR_RETURN(auto report,
                          store->erasures.ErasePerson(person.id, with_references, kCommandLine));
  Say("{} is erased: key destroyed, {} and {} removed, {} among them\n"
      "backups made before still hold name and login, and the key if it is kept inside them: "
      "delete "
      "them in due time; restoring one erases this person again if you name the newest key ring\n",
      login, Counted(report.attempts, "attempt"), Counted(report.blobs, "blob"),
      Counted(report.references, "reference cut"));
  for (const Mentions& one : report.mentions) {
    std::string places;
    for (const std::string& place : one.places) places += (places.empty() ? ": " : ", ") + place;
    Say("the name is still in what people typed, which stays until somebody edits it on the page: "
        "{}{}\n",
        Counted(one.count, one.kind), places);
  }
  if (!report.finished) {
    Say("copies of the erased data may remain in unused parts of the database until the server "
        "rewrites it: within an hour, or, if no server is running, after the next start\n");
  }
  return Status::Ok();
}

void DeclarePersonalData(CommandGroup admin) {
  struct Asked {
    std::filesystem::path data, target;
    std::string login, confirm;
    bool with_references = false;
  };
  auto [copy, c] =
      Declare<Asked>(admin, "export-person", "Write all that is kept about a person",
                     [](const Asked& o) { return ExportPerson(o.data, o.login, o.target); });
  AddData(copy, c.data);
  copy->add_option("--login", c.login, kLoginHelp)->required();
  copy->add_option("TARGET", c.target, "Folder to make; absent or empty")->required();
  AddExample(copy, "/tmp/anna --login anna");

  auto [erase, e] = Declare<Asked>(
      admin, "erase-person", "Erase everything that is kept about a person",
      [](const Asked& o) { return ErasePerson(o.data, o.login, o.confirm, o.with_references); });
  AddData(erase, e.data);
  erase->add_option("--login", e.login, kLoginHelp)->required();
  erase->add_option("--confirm", e.confirm, "The login once more: this cannot be undone")
      ->required();
  erase->add_flag("--with-references", e.with_references,
                  "Also when attempts of this person are reference cuts");
  AddExample(erase, "--login anna --confirm anna");
}

}  // namespace enamel::server::app
