#include "server/storage/audit/decisions.h"

#include <algorithm>
#include <boost/json.hpp>
#include <cstdio>
#include <initializer_list>
#include <optional>
#include <span>

#include "common/base/hex.h"
#include "server/storage/engine/query.h"
#include "server/storage/engine/sql_names.h"

namespace enamel::server {
namespace {

namespace json = boost::json;

// One statement's rows as columns of a state. `keyed`: many rows, each named by its first column.
struct StatePart {
  const char* name;
  std::string sql;
  bool keyed = false;
};

// A text, a UUID, two with a space between them, or a SHA-256.
enum class Key { kText, kId, kTwoIds, kHash };

struct SubjectKind {
  const char* name;
  Key key;
  const char* present;        // keys, and objects where they are others
  std::vector<StatePart> of;  // the first says whether it is there
};

// Columns that have a value under a condition.
std::string Where(const std::string& condition, std::initializer_list<const char*> columns) {
  std::string out;
  for (const std::string column : columns) {
    out += ", CASE WHEN " + condition + " THEN " + column + " END AS " + column;
  }
  return out;
}

// During a recording, chunks set two of the flags and count themselves without a row of their own;
// the seal's row has both. Of an attempt's state, only decisions of people and rules; the rest
// follows from the stored parts (verify/verify_stage.h).
std::string AttemptColumns() {
  const std::string quarantined = "state = " + Sql(AttemptState::kQuarantined);
  return "SELECT person, station, exercise, profile_content, ticket, assignment, exam, due_ms, "
         "rate_hz, limit_ticks, hands, sign_off, ticketed_ms, sealed_ms, as_reference, expired_ms, "
         "released, facts, CASE WHEN sealed_ms = 0 THEN "
         "flags - (flags & " +
         Sql(kFasterThanTime | kOverTime) +
         ") ELSE flags END AS flags, override_score, override_reason, override_by, override_ms, "
         "CASE WHEN " +
         quarantined + " THEN 1 END AS quarantined" +
         Where(quarantined, {"problem", "problem_field"}) +
         Where("(sealed_ms <> 0 OR expired_ms <> 0)",
               {"header", "head_hash", "head_state_hash", "chunks", "ticks", "gap_ticks",
                "trace_bytes", "last_chunk_ms"}) +
         " FROM attempts WHERE tenant = ?1 AND id = ?2";
}

const std::vector<SubjectKind>& Kinds() {
  static const std::vector<SubjectKind> kKinds = {
      {"attempt",
       Key::kId,
       "SELECT id FROM attempts WHERE tenant = ?1",
       {{"", AttemptColumns()},
        {"appeal",
         "SELECT filed_ms, text, state, answer, answered_by, answered_ms FROM appeals WHERE tenant "
         "= ?1 AND attempt = ?2"},
        {"sign_off",
         "SELECT stage, signer, signed_ms FROM sign_offs WHERE tenant = ?1 AND attempt = ?2 ORDER "
         "BY stage",
         true},
        {"reference",
         "SELECT id, exercise, version, dentist, consent, created_ms, withdrawn_ms FROM "
         "reference_cuts WHERE tenant = ?1 AND attempt = ?2 ORDER BY id",
         true},
        // A new reference has runs queued for all that have none, without a row about each.
        {"job",
         "SELECT id, kind, cause, batch FROM jobs WHERE tenant = ?1 AND attempt = ?2 AND cause <> "
         "'reference' ORDER BY id",
         true},
        {"evidence",
         "SELECT hash, seq, received_ms FROM contradicting_chunks WHERE tenant = ?1 AND attempt = "
         "?2 ORDER BY hash",
         true}}},
      {"annotation",
       Key::kId,
       "SELECT id, attempt FROM annotations WHERE tenant = ?1",
       {{"",
         "SELECT attempt, author, tick, x_um, y_um, z_um, text, created_ms, edited_ms, revision, "
         "to_chair, remark_id FROM annotations WHERE tenant = ?1 AND id = ?2"}}},
      {"saved_text",
       Key::kId,
       "SELECT id, owner FROM saved_texts WHERE tenant = ?1",
       {{"",
         "SELECT owner, text, shared, saved_ms FROM saved_texts WHERE tenant = ?1 AND id = ?2"}}},
      {"exercise",
       Key::kId,
       "SELECT id FROM exercises WHERE tenant = ?1",
       {{"",
         "SELECT name, version, title, content, scene, graded, published_ms, state FROM exercises "
         "WHERE tenant = ?1 AND id = ?2"},
        {"rubric",
         "SELECT version, content, reason, published_ms FROM rubrics WHERE tenant = ?1 AND "
         "exercise = ?2 ORDER BY version",
         true}}},
      {"owner",
       Key::kText,
       "SELECT name FROM exercise_owners WHERE tenant = ?1",
       {{"", "SELECT owner, shared FROM exercise_owners WHERE tenant = ?1 AND name = ?2"}}},
      {"assignment",
       Key::kId,
       "SELECT id FROM assignments WHERE tenant = ?1",
       {{"",
         "SELECT exercise_name, exercise, cohort, opens_ms, due_ms, attempt_limit, exam, "
         "late_allowed, hands, counting, sign_off, outline, created_ms FROM assignments WHERE "
         "tenant = ?1 AND id = ?2"},
        {"station",
         "SELECT station, 1 AS admitted FROM assignment_stations WHERE tenant = ?1 AND assignment "
         "= ?2 ORDER BY station",
         true}}},
      {"device",
       Key::kText,
       "SELECT name FROM listed_devices WHERE tenant = ?1",
       {{"", "SELECT title, added_ms FROM listed_devices WHERE tenant = ?1 AND name = ?2"}}},
      {"setting",
       Key::kText,
       "SELECT name || ' ' || scope FROM station_settings WHERE tenant = ?1",
       {{"",
         "SELECT value, fixed, changed_ms FROM station_settings WHERE tenant = ?1 AND name || ' ' "
         "|| scope = "
         "?2"}}},
      {"person",
       Key::kId,
       "SELECT id FROM people WHERE tenant = ?1",
       {{"",
         "SELECT login, display_name, role, disabled, created_ms, verifier, must_change_password, "
         "password_ms, pin, may_import_teeth FROM people WHERE tenant = ?1 AND id = ?2"}}},
      {"session",
       Key::kId,
       "SELECT id FROM sessions WHERE tenant = ?1",
       {{"",
         "SELECT token_hash, person, created_ms, expires_ms, confirmed_ms, via, address, device "
         "FROM sessions WHERE tenant = ?1 AND id = ?2"}}},
      {"erasure",
       Key::kHash,
       "SELECT person_hash FROM erasures WHERE tenant = ?1",
       {{"", "SELECT erased_ms FROM erasures WHERE tenant = ?1 AND person_hash = ?2"}}},
      {"cohort",
       Key::kId,
       "SELECT id FROM cohorts WHERE tenant = ?1",
       {{"", "SELECT name, archived_ms FROM cohorts WHERE tenant = ?1 AND id = ?2"}}},
      // Each by itself: a roster of thousands must not state all of them with each.
      {"member",
       Key::kTwoIds,
       "SELECT cohort, person FROM cohort_members WHERE tenant = ?1",
       {{"",
         "SELECT 1 AS member FROM cohort_members WHERE tenant = ?1 AND cohort = ?2 AND person = "
         "?3"}}},
      {"retention",
       Key::kText,
       "SELECT what FROM retention_rules WHERE tenant = ?1",
       {{"", "SELECT days FROM retention_rules WHERE tenant = ?1 AND what = ?2"}}},
      {"profile",
       Key::kText,
       "SELECT DISTINCT name FROM profile_versions WHERE tenant = ?1",
       {{"version",
         "SELECT version, title, content, created_ms FROM profile_versions WHERE tenant = ?1 AND "
         "name = ?2 ORDER BY version",
         true},
        {"newest", "SELECT title, content FROM profiles WHERE tenant = ?1 AND name = ?2"},
        {"report",
         "SELECT id, version, media_type, content, bytes, created_ms FROM profile_reports WHERE "
         "tenant = ?1 AND name = ?2 ORDER BY id",
         true},
        {"calibration",
         "SELECT id, device, measured_ms, added_ms, document FROM calibrations WHERE tenant = ?1 "
         "AND profile = ?2 ORDER BY id",
         true}}},
      {"scene",
       Key::kHash,
       "SELECT content FROM scenes WHERE tenant = ?1",
       {{"", "SELECT name, title, volume FROM scenes WHERE tenant = ?1 AND content = ?2"}}},
      {"marking",
       Key::kId,
       "SELECT id FROM markings WHERE tenant = ?1",
       {{"", "SELECT assignment, created_ms, ended_ms FROM markings WHERE tenant = ?1 AND id = ?2"},
        {"marker",
         "SELECT person, removed_ms FROM marking_people WHERE tenant = ?1 AND marking = ?2 ORDER "
         "BY person",
         true}}},
      // Each by itself: one goes with its attempt.
      {"work",
       Key::kId,
       "SELECT id FROM marking_works WHERE tenant = ?1",
       {{"", "SELECT marking, attempt FROM marking_works WHERE tenant = ?1 AND id = ?2"},
        {"mark",
         "SELECT marker, rating, criteria, made_ms FROM marks WHERE tenant = ?1 AND work = ?2 "
         "ORDER BY marker",
         true}}},
      {"code",
       Key::kId,
       "SELECT id FROM enrol_codes WHERE tenant = ?1",
       {{"",
         "SELECT code_hash, created_ms, expires_ms, used_ms, withdrawn_ms FROM enrol_codes WHERE "
         "tenant = ?1 AND id = ?2"}}},
      {"station",
       Key::kId,
       "SELECT id FROM stations WHERE tenant = ?1",
       {{"",
         "SELECT name, public_key, credential_hash, revoked, revoked_ms, enrolled_ms FROM stations "
         "WHERE tenant = ?1 AND id = ?2"}}}};
  return kKinds;
}

// Not repeated: words may be long, and the trail must not name further people.
constexpr const char* kWords[] = {
    "override_reason", "text",     "answer",       "dentist",  "reason",
    "login",           "verifier", "display_name", "pin",      "facts",
    "problem",         "address",  "device",       "criteria", "document"};
// Ids, hashes and keys are repeated; what is longer (a ticket, a header) is not.
constexpr size_t kLongestRepeated = 32;

std::string ValueOf(const Query& q, int column, const std::string& name) {
  switch (q.TypeOf(column)) {
    case sql::Type::kNull:
      return "";
    case sql::Type::kInt:
      return std::to_string(q.Int(column));
    case sql::Type::kReal: {
      char text[40];
      std::snprintf(text, sizeof text, "%.17g", q.Real(column));
      return text;
    }
    case sql::Type::kBlob: {
      const Bytes bytes = q.Blob(column);
      if (bytes.size() > kLongestRepeated) return "sha256 " + HashSha256(bytes).Hex();
      return bytes.size() == 16 ? q.Id(column).Text() : ToHex(bytes);
    }
    case sql::Type::kText:
      break;
  }
  const std::string text = q.Text(column);
  const bool words = std::ranges::find(kWords, name) != std::end(kWords);
  return words && !text.empty() ? "sha256 " + HashSha256(AsBytes(text)).Hex() : text;
}

// False: no row.
Result<bool> AddPart(Db& db, const StatePart& part, const SubjectKind& kind, const std::string& key,
                     json::object& state) {
  Query q(db, part.sql);
  if (kind.key == Key::kText) {
    q.Bind(key);
  } else if (kind.key == Key::kHash) {
    ENAMEL_ASSIGN_OR_RETURN(const Sha256 hash, Sha256::FromHex(key));
    q.Bind(hash);
  } else {
    const size_t space = key.find(' ');
    ENAMEL_ASSIGN_OR_RETURN(const Uuid id, Uuid::Parse(key.substr(0, space)));
    q.Bind(id);
    if (kind.key == Key::kTwoIds) {
      if (space == std::string::npos) {
        return Status(Code::kInternal, "expected two ids, found \"" + key + "\"");
      }
      ENAMEL_ASSIGN_OR_RETURN(const Uuid second, Uuid::Parse(key.substr(space + 1)));
      q.Bind(second);
    }
  }
  bool found = false;
  while (q.Next()) {
    found = true;
    std::string prefix = part.name;
    if (part.keyed) prefix += " " + ValueOf(q, 0, "");
    if (!prefix.empty()) prefix += " ";
    for (int i = part.keyed ? 1 : 0; i < q.columns(); ++i) {
      const std::string name = q.NameOf(i);
      const std::string value = ValueOf(q, i, name);
      if (!value.empty()) state[prefix + name] = value;
    }
  }
  ENAMEL_RETURN_IF_ERROR(q.status());
  return found;
}

}  // namespace

std::string SubjectOf(const std::string& kind, const std::string& key) { return kind + " " + key; }

std::string SubjectOfAction(const std::string& action, const std::string& object) {
  static const std::pair<const char*, const char*> kPrefixes[] = {{"attempt.", "attempt"},
                                                                  {"appeal.", "attempt"},
                                                                  {"reference.", "attempt"},
                                                                  {"exercise.", "exercise"},
                                                                  {"owner.", "owner"},
                                                                  {"assignment.", "assignment"},
                                                                  {"device.", "device"},
                                                                  {"setting.", "setting"},
                                                                  {"person.erase", "erasure"},
                                                                  {"person.", "person"},
                                                                  {"station.enrol", "station"},
                                                                  {"station.rename", "station"},
                                                                  {"station.revoke", "station"},
                                                                  {"station.code", "code"},
                                                                  {"cohort.create", "cohort"},
                                                                  {"cohort.edit", "cohort"},
                                                                  {"retention.set", "retention"},
                                                                  {"profile.", "profile"},
                                                                  {"marking.begin", "marking"},
                                                                  {"marking.markers", "marking"},
                                                                  {"marking.end", "marking"},
                                                                  {"marking.work", "work"},
                                                                  {"marking.mark", "work"}};
  for (const auto& [prefix, kind] : kPrefixes) {
    if (action.starts_with(prefix)) return SubjectOf(kind, object);
  }
  return "";
}

Result<std::string> StateOf(Db& db, const std::string& subject) {
  const size_t space = subject.find(' ');
  const std::string name = subject.substr(0, space);
  const auto kind = std::ranges::find(Kinds(), name, &SubjectKind::name);
  if (space == std::string::npos || kind == Kinds().end()) {
    return Status(Code::kInternal, "expected a kind and a key, found \"" + subject + "\"");
  }
  const std::string key = subject.substr(space + 1);
  json::object state;
  for (size_t i = 0; i < kind->of.size(); ++i) {
    ENAMEL_ASSIGN_OR_RETURN(const bool found, AddPart(db, kind->of[i], *kind, key, state));
    if (i == 0 && !found) return std::string();
  }
  return json::serialize(state);
}

std::map<std::string, std::string> ColumnsOf(const std::string& state) {
  std::map<std::string, std::string> out;
  boost::system::error_code error;
  const json::value value = json::parse(state, error);
  if (error || !value.is_object()) return out;
  for (const auto& [name, text] : value.as_object()) {
    if (text.is_string()) out[std::string(name)] = std::string(text.as_string());
  }
  return out;
}

Result<std::vector<PresentSubject>> PresentSubjects(Db& db) {
  std::vector<PresentSubject> out;
  for (const SubjectKind& kind : Kinds()) {
    Query q(db, kind.present);
    while (q.Next()) {
      std::string key = kind.key == Key::kText   ? q.Text(0)
                        : kind.key == Key::kHash ? q.Hash(0).Hex()
                                                 : q.Id(0).Text();
      std::string object = key;
      if (kind.key == Key::kTwoIds) {
        key += " " + q.Id(1).Text();
      } else if (q.columns() > 1) {
        object = q.Id(1).Text();
      }
      out.push_back({SubjectOf(kind.name, key), object});
    }
    ENAMEL_RETURN_IF_ERROR(q.status());
  }
  return out;
}

}  // namespace enamel::server
