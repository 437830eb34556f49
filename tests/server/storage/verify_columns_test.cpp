#include <map>
#include <regex>
#include <set>
#include <sstream>

#include "common/base/file.h"
#include "tests/server/storage/decided_school.h"

// Every column of every table is edited, rows are deleted, and contents of rows exchanged. `verify`
// finds each edit, or schemas/audit.md lists it with the reason why nothing is lost. Tables and
// columns are those of the database: a new column fails this test until one of the two is true.
namespace enamel::server {
namespace {

using namespace testing;

// SQL literals by column.
using Row = std::vector<std::string>;

struct Column {
  std::string name, type;
  bool is_key = false;
};

struct TableRows {
  std::string name;
  std::vector<std::string> words;  // literals of its checks: 'best', 'last'
  std::vector<Column> columns;
  std::vector<Row> rows;
};

// A connection that nobody else has, past the store.
class Raw {
 public:
  explicit Raw(const fs::path& file) {
    EXPECT_EQ(sqlite3_open(file.c_str(), &handle_), SQLITE_OK);
    Run("PRAGMA synchronous = 0; PRAGMA foreign_keys = 0");
  }
  ~Raw() { sqlite3_close(handle_); }
  Raw(const Raw&) = delete;
  Raw& operator=(const Raw&) = delete;

  // False: a constraint forbids it.
  bool Try(const std::string& sql) {
    const int code = sqlite3_exec(handle_, sql.c_str(), nullptr, nullptr, nullptr);
    return code == SQLITE_OK;
  }
  void Run(const std::string& sql) {
    EXPECT_TRUE(Try(sql)) << sqlite3_errmsg(handle_) << ": " << sql;
  }
  bool Changed() { return sqlite3_changes(handle_) > 0; }
  std::vector<Row> Read(const std::string& sql) {
    sqlite3_stmt* statement = nullptr;
    EXPECT_EQ(sqlite3_prepare_v2(handle_, sql.c_str(), -1, &statement, nullptr), SQLITE_OK)
        << sqlite3_errmsg(handle_) << ": " << sql;
    std::vector<Row> out;
    while (sqlite3_step(statement) == SQLITE_ROW) {
      Row& row = out.emplace_back();
      for (int i = 0; i < sqlite3_column_count(statement); ++i) {
        const auto* text = reinterpret_cast<const char*>(sqlite3_column_text(statement, i));
        row.emplace_back(text == nullptr ? "" : text);
      }
    }
    sqlite3_finalize(statement);
    return out;
  }

 private:
  sqlite3* handle_ = nullptr;
};

std::vector<TableRows> TablesOf(Raw& db) {
  std::vector<TableRows> out;
  for (const Row& table :
       db.Read("SELECT name, sql FROM sqlite_schema WHERE type = 'table' AND name NOT "
               "LIKE 'sqlite%' ORDER BY name")) {
    TableRows& rows = out.emplace_back();
    rows.name = table[0];
    static const std::regex kWord("'[a-z_]+'");
    for (std::sregex_iterator word(table[1].begin(), table[1].end(), kWord), end; word != end;
         ++word) {
      rows.words.push_back(word->str());
    }
    std::string quoted;
    for (const Row& column :
         db.Read("SELECT name, type, pk FROM pragma_table_info('" + rows.name + "')")) {
      rows.columns.push_back({column[0], column[1], column[2] != "0"});
      quoted += (quoted.empty() ? "quote(" : ", quote(") + column[0] + ")";
    }
    rows.rows = db.Read("SELECT " + quoted + " FROM " + rows.name);
  }
  return out;
}

std::string KeyOf(const TableRows& table, const Row& row) {
  std::string out;
  for (size_t i = 0; i < row.size(); ++i) {
    if (!table.columns[i].is_key) continue;
    out += (out.empty() ? "" : " AND ") + table.columns[i].name + " = " + row[i];
  }
  return out;
}

// Values that the column may have instead: another row's, which looks genuine, or a made one.
std::vector<std::string> InPlaceOf(const TableRows& table, size_t column, size_t row) {
  const std::string& is = table.rows[row][column];
  std::vector<std::string> out;
  for (size_t i = 1; i < table.rows.size(); ++i) {
    const std::string& other = table.rows[(row + i) % table.rows.size()][column];
    if (other != is && other != "NULL") out.push_back(other);
  }
  const std::string& type = table.columns[column].type;
  if (type == "INTEGER" || type == "REAL") {
    for (const char* by : {" + 1", " - 1", " + 1000"}) out.push_back(is == "NULL" ? "1" : is + by);
  } else if (type == "TEXT") {
    out.push_back(is == "NULL" ? "'x'" : is + " || 'x'");
    for (const std::string& word : table.words) {
      if (word != is) out.push_back(word);
    }
  } else {
    for (size_t bytes : {16, 32, 64}) out.push_back("x'" + std::string(2 * bytes, '7') + "'");
  }
  return out;
}

// schemas/audit.md, "What an edit may change": what, and how often that was seen here.
std::map<std::string, int> ListedEdits() {
  std::map<std::string, int> out;
  const auto text = ReadFile(ENAMEL_SOURCE_DIR "/schemas/audit.md");
  EXPECT_TRUE(text.ok());
  std::istringstream lines{std::string(AsText(*text))};
  bool inside = false;
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with("## ")) inside = line == "## What an edit may change";
    if (!inside || !line.starts_with("| `")) continue;
    const size_t reason = line.find("| ", 3);
    EXPECT_TRUE(reason != std::string::npos && line.size() > reason + 10) << "a reason: " << line;
    // `a.b`, `a.c`
    for (size_t at = line.find('`'); at < reason; at = line.find('`', at + 1)) {
      const size_t end = line.find('`', at + 1);
      EXPECT_TRUE(out.emplace(line.substr(at + 1, end - at - 1), 0).second) << "twice: " << line;
      at = end;
    }
  }
  return out;
}

class VerifyColumnsTest : public DecidedSchoolTest {
 protected:
  VerifyColumnsTest() {
    Fill();
    ExpectWhole("before anything is changed");
    school_.store.reset();
    {
      Raw db(Data() / "enamel.db");
      FillRunningState(db);
      db.Run(without_triggers_ + "PRAGMA journal_mode = DELETE; VACUUM");
    }
    ExpectWhole("at rest");
    kept_ = *ReadFile(Data() / "enamel.db");
    // Without it signatures of the trail are not checked, which takes most of the time. Only what
    // is not found so is looked at again, with the key.
    ticket_key_ = *ReadFile(Data() / "ticket.key");
    fs::remove(Data() / "ticket.key");
  }

  void Fill();
  void FillAttempts(const Actor& by);
  static void FillRunningState(Raw& db);

  bool IsFound(bool with_key) {
    if (with_key) EXPECT_TRUE(WriteFile(Data() / "ticket.key", ticket_key_));
    const auto report = Verify({Data(), {}, {}});
    if (with_key) fs::remove(Data() / "ticket.key");
    return !report.ok() || !report->findings.empty();
  }
  static bool WriteFile(const fs::path& path, ByteView bytes) {
    std::ofstream out(path, std::ios::binary);
    out.write(reinterpret_cast<const char*>(bytes.data()),
              static_cast<std::streamsize>(bytes.size()));
    return out.good();
  }

  // False: no such edit can be made.
  bool Make(const std::vector<std::string>& edits) {
    WriteFile(Data() / "enamel.db", kept_);
    Raw db(Data() / "enamel.db");
    const auto make = [&] {
      return std::ranges::any_of(
          edits, [&](const std::string& edit) { return db.Try(edit) && db.Changed(); });
    };
    if (make()) return true;
    // The column has no other value that its check admits.
    db.Run("PRAGMA ignore_check_constraints = 1");
    return make();
  }

  // One edit, however it can be made.
  void Expect(const std::string& table, const std::string& what,
              const std::vector<std::string>& edits) {
    if (!Make(edits)) {
      ADD_FAILURE() << "no edit of " << what << " passes the schema's constraints";
      return;
    }
    ++edits_;
    const bool of_the_trail = table == "audit" || table == "audit_heads";
    if (!of_the_trail && IsFound(/*with_key=*/false)) return;
    if (IsFound(/*with_key=*/true)) return;
    for (const std::string& name : {what, table + ".*"}) {
      if (const auto at = listed_.find(name); at != listed_.end()) {
        ++at->second;
        return;
      }
    }
    not_found_.insert(what);
  }

  void EditColumns(const TableRows& table, size_t row);
  void DeleteRow(const TableRows& table, size_t row);
  void Exchange(const TableRows& table);

  std::map<std::string, int> listed_ = ListedEdits();
  std::set<std::string> not_found_;
  int edits_ = 0;
  Bytes kept_, ticket_key_;
};

void VerifyColumnsTest::FillAttempts(const Actor& by) {
  Store& store = *school_.store;
  const Uuid ada = AddPerson(store, "ada", Role::kStudent);
  school_.with_motion = true;
  // Scored twice, thrice, taken back.
  for (int runs = 1; runs <= 3; ++runs) {
    const Uuid attempt = school_.RecordOf(runs == 2 ? ada : student(), 2);
    school_.Score(attempt, scored_);
    for (int run = 1; run < runs; ++run) school_.ScoreAgain(attempt, 60 + run);
    if (runs == 3) EXPECT_TRUE(store.results.RestoreResult(attempt, 2, by, {}).ok());
    EXPECT_TRUE(store.judging.ReleaseAttempt(attempt, by, {}).ok());
    EXPECT_TRUE(store.appeals.FileAppeal(attempt, "the wall", Actor{student(), "page"}).ok());
    EXPECT_TRUE(
        store.judging.OverrideScore(attempt, ScoreOverride{50. + runs, "seen", {}, 0}, by, {})
            .ok());
    AnnotationRow remark;
    remark.attempt = attempt;
    remark.tick = static_cast<uint64_t>(runs);
    remark.point_um = {runs, 2, 3};
    remark.text = "remark " + std::to_string(runs);
    remark.to_chair = runs > 1;
    EXPECT_TRUE(store.remarks.AddAnnotation(remark, by).ok());
  }
  for (const Uuid& attempt : {scored_, graded_}) {
    const Sha256 made = *store.blobs.PutAttemptBlob(attempt, AsBytes("what it looked like"));
    EXPECT_TRUE(store.timelines.PutTimeline(attempt, made).ok());
  }
  uint32_t left_out = 0;
  BatchRow batch{{}, "Year 2", "rubric"};
  EXPECT_TRUE(store.batches.RescoreTogether(batch, {scored_}, left_out, by).ok());
  // Sealed, and waiting for its run; one that failed; two that were recorded twice.
  school_.Seal(school_.Record(1));
  const Uuid failed = school_.Record(1);
  school_.Seal(failed);
  EXPECT_TRUE(
      store.results.FailAttempt(failed, Status(Code::kInvalidInput, "no tooth", "tooth"), {}).ok());
  for (int i = 1; i < 3; ++i) {
    const Uuid twice = school_.Record(2);
    EXPECT_TRUE(store.tickets.KeepFacts(twice, R"({"resumed":)" + std::to_string(i) + "}").ok());
    const auto other = [&](int n) {
      return school_.world.Chunk(twice, 0, HashSha256(AsBytes("other")), n);
    };
    EXPECT_EQ(store.ingest.AppendChunk(other(i)).code(), Code::kConflict);
    EXPECT_EQ(store.ingest.AppendChunk(other(i + 2)).code(), Code::kConflict);
  }
  // Tickets, two of them signed at the start.
  for (int i = 0; i < 2; ++i) {
    AttemptRow row = school_.world.AttemptOf(student());
    row.sign_off = true;
    EXPECT_TRUE(store.tickets.CreateAttempt(row, AsBytes("ticket"), kSystem).ok());
    EXPECT_TRUE(store.sign_offs.Sign(row.id, SignedAt::kStart, 7 + i, by).ok());
  }
}

void VerifyColumnsTest::Fill() {
  Store& store = *school_.store;
  const Actor by{teacher_, "page"};
  const Uuid marker = AddPerson(store, "marker", Role::kInstructor);
  const Uuid third = AddPerson(store, "third", Role::kInstructor);
  // Of the reference: whoever scores below has the one run that waits.
  const auto waiting = *store.jobs.Jobs("queued");
  for (const JobRow& job : waiting) {
    EXPECT_TRUE(store.jobs.CancelJob(job.id, by).ok());
  }
  EXPECT_TRUE(store.people.SetPin(marker, "verifier of a PIN", by).ok());
  EXPECT_TRUE(store.people.SetPassword(third, "verifier", true, by).ok());
  EXPECT_TRUE(store.people.SetLanguage(third, "de").ok());
  for (int i = 0; i < 3; ++i) {
    const std::string n = std::to_string(i);
    const Uuid cohort = *store.cohorts.CreateCohort("Year " + n, by);
    EXPECT_TRUE(store.cohorts.ChangeMembers(cohort, {student(), teacher_}, {}, by).ok());
    if (i == 2) EXPECT_TRUE(store.cohorts.EditCohort(cohort, {std::nullopt, true}, 1, by).ok());
    SessionRow session{
        HashSha256(AsBytes("token " + n)), i == 0 ? teacher_ : student(), 100 + i, 200,
        1'000'000'000'000'000 + i,         i == 1 ? "station" : "page"};
    session.address = "192.0.2." + n;
    session.device = "Firefox " + n;
    EXPECT_TRUE(store.sessions.CreateSession(session).ok());
    EXPECT_TRUE(store.sessions.ConfirmSession(session.token_hash, 300 + i).ok());
    // Codes: used, withdrawn, open.
    const Sha256 code = HashSha256(AsBytes("code " + n));
    const Uuid code_id = *store.stations.AddEnrolCode(code, 9'000 + i, by);
    StationRow station;
    station.name = "station " + n;
    station.public_key.assign(32, static_cast<uint8_t>(i));
    if (i == 0) EXPECT_TRUE(store.stations.WithdrawEnrolCode(code_id, by).ok());
    if (i > 0) {
      const auto credential = HashSha256(AsBytes("credential " + n));
      station.id = store.stations.EnrolStation(code, station, credential, 10)->id;
      EXPECT_TRUE(store.stations.TouchStation(station.id, "1." + n, 7, 20).ok());
    }
    if (i == 1) EXPECT_TRUE(store.stations.RevokeStation(station.id, by).ok());
    EXPECT_TRUE(store.devices.ListDevice("device " + n, "chair 9" + n, by).ok());
    const char* const language = i == 0 ? "en" : i == 1 ? "de" : "zh";
    EXPECT_TRUE(
        store.settings.PutSetting({"language", "lab" + n + "-*", language, i == 1, 0}, by).ok());
    for (int version = 0; version < 2; ++version) {
      const std::string name = "profile " + n;
      const Sha256 content = PutText(store, name + " " + std::to_string(version));
      EXPECT_TRUE(store.profiles.PutProfile({name, "Title of " + name, content}, by).ok());
      EXPECT_TRUE(store.profiles
                      .AddProfileReport({{},
                                         name,
                                         1,
                                         version == 0 ? "text/html" : "application/json",
                                         content,
                                         7 + static_cast<uint64_t>(i)},
                                        by)
                      .ok());
      EXPECT_TRUE(store.profiles
                      .AddCalibration({{},
                                       name,
                                       "device " + n,
                                       version + 1,
                                       0,
                                       "{\"n\":" + std::to_string(version) + "}"},
                                      by)
                      .ok());
    }
    const Sha256 scene = PutText(store, "scene " + n), volume = PutText(store, "volume " + n);
    EXPECT_TRUE(store.scenes.PutScene({"scene " + n, "Scene " + n, scene, volume}, by).ok());
    EXPECT_TRUE(store.scenes.PutSceneSurface(volume, PutText(store, "surface " + n)).ok());
    EXPECT_TRUE(store.timelines.PutStartTooth(volume, PutText(store, "start " + n)).ok());
    auto exercise =
        store.exercises.PublishExercise(school_.world.Exercise("exercise " + n, n), cohort, by);
    RubricRow rubric{exercise->id, 2, PutText(store, "rubric of " + n), "reason " + n, 0};
    EXPECT_TRUE(store.rubrics.PublishRubric(rubric, by).ok());
    EXPECT_TRUE(store.retention
                    .SetRetention({i == 0   ? "unfinished"
                                   : i == 1 ? "recordings"
                                            : "attempts",
                                   500 + i},
                                  by)
                    .ok());
    AssignmentRow work;
    work.exercise = "exercise " + n;
    work.opens_ms = 1 + i;
    work.due_ms = 9'000'000'000'000 + i;
    work.stations = {school_.world.station};
    const Uuid assignment = store.assignments.AddAssignment(work, by)->id;
    // Blind: two works, of which the first is marked by both.
    if (i < 2) {
      const Uuid first = school_.Record(1), second = school_.Record(1);
      school_.Score(first);
      school_.Score(second);
      auto marking = store.markings.BeginMarking(assignment, {first, second}, {marker, third}, by);
      ASSERT_TRUE(marking.ok()) << marking.status().message();
      const auto works = *store.markings.WorksOf(marking->id);
      for (const MarkingWork& at : works) {
        for (const Uuid& person : {marker, third}) {
          if (at.attempt == second && person == third) continue;
          BlindMark mark{at.id, person, 2 + i + (person == third ? 1 : 0), "[{\"name\":\"wall\"}]"};
          const Status marked = store.markings.AddMark(mark, {person, "page"});
          EXPECT_TRUE(marked.ok()) << marked.message();
        }
      }
      if (i == 1) {
        EXPECT_TRUE(store.markings.SetMarkers(marking->id, {marker, teacher_}, by).ok());
        EXPECT_TRUE(store.markings.EndMarking(marking->id, by).ok());
      }
    }
  }
  // Erased, with and without work.
  for (int i = 0; i < 2; ++i) {
    const Uuid gone = AddPerson(store, "gone" + std::to_string(i), Role::kStudent);
    if (i == 0) school_.Score(school_.RecordOf(gone, 1));
    EXPECT_TRUE(store.erasures.ErasePerson(gone, true, by).ok());
  }
  FillAttempts(by);
  EXPECT_TRUE(store.exercises.PutDraft(school_.world.Exercise("draft", "d"), by).ok());
}

// What changes without a decision while servers run, and is empty or away in a folder at rest.
void VerifyColumnsTest::FillRunningState(Raw& db) {
  const char* const kRows[] = {
      "INSERT INTO blobs VALUES (1, randomblob(32), 1, 1, 1), (1, randomblob(32), 2, 2, 2)",
      "INSERT INTO person_keys VALUES (1, randomblob(16), 1, randomblob(32), 1)",
      "INSERT INTO server_identity VALUES (1, 'ticket_key', randomblob(32))",
      "INSERT INTO sign_in_counters VALUES (1, randomblob(32), 1, 1, 1, 1, 1)",
      "INSERT INTO leases VALUES (1, 'upkeep', randomblob(16), 1)",
      "INSERT INTO rewrite_due VALUES (1, 1, randomblob(16))",
      "INSERT INTO running_servers VALUES (1, randomblob(16), 1)",
      "INSERT INTO station_links VALUES (1, randomblob(16), randomblob(16), 1)",
      "INSERT INTO schools VALUES (1, 'north', randomblob(16), 'north.test', 'served', 1)",
      "INSERT INTO write_probe VALUES (1, randomblob(16), 1, 1, 1, '', 1)",
      "INSERT INTO move_marks VALUES (1, 'moved')"};
  for (const char* row : kRows) db.Run(row);
}

void VerifyColumnsTest::EditColumns(const TableRows& table, size_t row) {
  for (size_t column = 0; column < table.columns.size(); ++column) {
    const std::string& name = table.columns[column].name;
    // Another tenant's row is none, as a deleted one.
    if (name == "tenant") continue;
    std::vector<std::string> edits;
    for (const std::string& value : InPlaceOf(table, column, row)) {
      edits.push_back("UPDATE " + table.name + " SET " + name + " = " + value + " WHERE " +
                      KeyOf(table, table.rows[row]));
    }
    Expect(table.name, table.name + "." + name, edits);
  }
}

void VerifyColumnsTest::DeleteRow(const TableRows& table, size_t row) {
  Expect(table.name, table.name + " deleted",
         {"DELETE FROM " + table.name + " WHERE " + KeyOf(table, table.rows[row])});
}

// The contents of two rows that differ in more than listed columns.
void VerifyColumnsTest::Exchange(const TableRows& table) {
  std::vector<size_t> contents;
  for (size_t i = 0; i < table.columns.size(); ++i) {
    const Column& column = table.columns[i];
    if (!column.is_key && !listed_.contains(table.name + "." + column.name)) contents.push_back(i);
  }
  for (size_t a = 0; a < table.rows.size(); ++a) {
    for (size_t b = a + 1; b < table.rows.size(); ++b) {
      const bool differ = std::ranges::any_of(
          contents, [&](size_t i) { return table.rows[a][i] != table.rows[b][i]; });
      if (!differ) continue;
      std::string sql = "BEGIN; DELETE FROM " + table.name + " WHERE (" +
                        KeyOf(table, table.rows[a]) + ") OR (" + KeyOf(table, table.rows[b]) + ")";
      for (const auto& [key, content] : {std::pair(a, b), std::pair(b, a)}) {
        Row row = table.rows[key];
        for (size_t i : contents) row[i] = table.rows[content][i];
        sql += "; INSERT INTO " + table.name + " VALUES (";
        for (size_t i = 0; i < row.size(); ++i) sql += (i == 0 ? "" : ", ") + row[i];
        sql += ")";
      }
      return Expect(table.name, table.name + " exchanged", {sql + "; COMMIT"});
    }
  }
}

TEST_F(VerifyColumnsTest, EveryEditIsFoundOrListedWithItsReason) {
  std::vector<TableRows> tables;
  {
    Raw db(Data() / "enamel.db");
    tables = TablesOf(db);
  }
  EXPECT_GT(tables.size(), 40u);
  std::set<std::string> names;
  for (const TableRows& table : tables) {
    SCOPED_TRACE(table.name);
    EXPECT_FALSE(table.rows.empty())
        << "no row of " << table.name << " is edited: Fill() adds some";
    names.insert({table.name + ".*", table.name + " deleted", table.name + " exchanged"});
    for (const Column& column : table.columns) names.insert(table.name + "." + column.name);
    if (table.rows.empty()) continue;
    EditColumns(table, 0);
    DeleteRow(table, table.rows.size() - 1);
    Exchange(table);
  }
  for (const std::string& what : not_found_) {
    ADD_FAILURE() << "verify does not find an edit of " << what
                  << ": state it in a decision (decisions.cpp), compare it, or list it in "
                     "schemas/audit.md with a reason";
  }
  for (const auto& [what, seen] : listed_) {
    EXPECT_TRUE(names.contains(what))
        << what << " is listed in schemas/audit.md and does not exist";
    EXPECT_TRUE(seen > 0 || !names.contains(what))
        << what << " is listed in schemas/audit.md, and verify finds each edit of it";
  }
  RecordProperty("edits", edits_);
}

}  // namespace
}  // namespace enamel::server
