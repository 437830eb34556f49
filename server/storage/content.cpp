#include "server/storage/sqlite_impl.h"

// Device profiles, scenes, exercises.
namespace enamel::server::sqlite {
namespace {

ExerciseRow ExerciseOf(const Query& q) {
  ExerciseRow out;
  out.id = q.Id(0);
  out.name = q.Text(1);
  out.version = static_cast<int32_t>(q.Int(2));
  out.title = q.Text(3);
  out.content = q.Hash(4);
  out.scene = q.Hash(5);
  out.graded = q.Int(6) != 0;
  out.published_ms = q.Int(7);
  return out;
}

Result<std::vector<ExerciseRow>> ExercisesIn(Query& q) {
  std::vector<ExerciseRow> out;
  while (q.Next()) out.push_back(ExerciseOf(q));
  if (!q.status().ok()) return q.status();
  return out;
}

Result<std::optional<ExerciseRow>> MaybeExercise(Query& q) {
  std::optional<ExerciseRow> out;
  if (q.Next()) out = ExerciseOf(q);
  if (!q.status().ok()) return q.status();
  return out;
}

Result<ExerciseRow> OneExercise(Query& q, const std::string& what) {
  auto found = MaybeExercise(q);
  if (!found.ok()) return found.status();
  if (*found) return **found;
  return Status(Code::kNotFound, "no exercise " + what);
}

Status Assign(Db& db, const std::string& exercise, const Uuid& cohort) {
  Query q(db,
          "INSERT INTO assignments (tenant, exercise_name, cohort) VALUES (?1, ?2, ?3) "
          "ON CONFLICT DO NOTHING");
  return q.Bind(exercise).Bind(cohort).Run();
}

Status InsertExercise(Db& db, const ExerciseRow& row, const Actor& by) {
  Query q(db,
          "INSERT INTO exercises (tenant, id, name, version, title, content, scene, graded, "
          "published_ms) "
          "VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9)");
  q.Bind(row.id).Bind(row.name).Bind(int64_t{row.version}).Bind(row.title).Bind(row.content);
  q.Bind(row.scene).Bind(static_cast<int64_t>(row.graded)).Bind(row.published_ms);
  ENAMEL_RETURN_IF_ERROR(Explain(
      q.Run(), "the exercise's scene " + row.scene.Hex() + " is not stored; put the scene first"));
  return WriteAudit(db, by, "exercise.publish", row.id.Text(), "{}",
                    JsonOf({{"name", row.name},
                            {"version", std::to_string(row.version)},
                            {"content", row.content.Hex()}}));
}

}  // namespace

Status SqliteStore::PutProfile(const ProfileRow& row, const Actor& by) {
  return Write([&](Db& db) -> Status {
    std::string before = "{}";
    {
      Query old(db, "SELECT content FROM profiles WHERE tenant = ?1 AND name = ?2");
      if (old.Bind(row.name).Next()) {
        if (old.Hash(0) == row.content) return Status::Ok();
        before = JsonOf({{"content", old.Hash(0).Hex()}});
      }
      ENAMEL_RETURN_IF_ERROR(old.status());
    }
    Query q(db,
            "INSERT INTO profiles (tenant, name, title, content) VALUES (?1, ?2, ?3, ?4) "
            "ON CONFLICT (tenant, name) DO UPDATE SET title = excluded.title, content = "
            "excluded.content");
    ENAMEL_RETURN_IF_ERROR(q.Bind(row.name).Bind(row.title).Bind(row.content).Run());
    return WriteAudit(db, by, "profile.put", row.name, before,
                      JsonOf({{"content", row.content.Hex()}}));
  });
}

Result<std::vector<ProfileRow>> SqliteStore::Profiles() {
  return Read([&](Db& db) -> Result<std::vector<ProfileRow>> {
    Query q(db, "SELECT name, title, content FROM profiles WHERE tenant = ?1 ORDER BY name");
    std::vector<ProfileRow> out;
    while (q.Next()) out.push_back(ProfileRow{q.Text(0), q.Text(1), q.Hash(2)});
    if (!q.status().ok()) return q.status();
    return out;
  });
}

Status SqliteStore::PutScene(const SceneRow& row, const Actor& by) {
  if (!blobs_.Has(row.content) || !blobs_.Has(row.volume)) {
    return Status(Code::kNotFound,
                  "the scene's document or volume is not stored; put both blobs first");
  }
  return Write([&](Db& db) -> Status {
    Query q(db,
            "INSERT INTO scenes (tenant, name, title, content, volume) VALUES (?1, ?2, ?3, ?4, ?5) "
            "ON CONFLICT DO NOTHING");
    ENAMEL_RETURN_IF_ERROR(
        q.Bind(row.name).Bind(row.title).Bind(row.content).Bind(row.volume).Run());
    if (db.Changes() == 0) return Status::Ok();
    return WriteAudit(db, by, "scene.put", row.name, "{}",
                      JsonOf({{"content", row.content.Hex()}}));
  });
}

Result<std::vector<SceneRow>> SqliteStore::Scenes() {
  return Read([&](Db& db) -> Result<std::vector<SceneRow>> {
    Query q(db, "SELECT name, title, content, volume FROM scenes WHERE tenant = ?1 ORDER BY name");
    std::vector<SceneRow> out;
    while (q.Next()) out.push_back(SceneRow{q.Text(0), q.Text(1), q.Hash(2), q.Hash(3)});
    if (!q.status().ok()) return q.status();
    return out;
  });
}

Result<ExerciseRow> SqliteStore::PublishExercise(ExerciseRow row, const Uuid& cohort,
                                                 const Actor& by) {
  Status status = Write([&](Db& db) -> Status {
    std::optional<ExerciseRow> newest;
    {
      Query q(
          db,
          "SELECT id, name, version, title, content, scene, graded, published_ms FROM exercises "
          "WHERE tenant = ?1 AND name = ?2 ORDER BY version DESC LIMIT 1");
      auto found = MaybeExercise(q.Bind(row.name));
      if (!found.ok()) return found.status();
      newest = *found;
    }
    ENAMEL_RETURN_IF_ERROR(Assign(db, row.name, cohort));
    if (newest && newest->content == row.content) {
      row = *newest;
      return Status::Ok();
    }
    row.id = Uuid::New();
    row.version = newest ? newest->version + 1 : 1;
    row.published_ms = NowMs();
    return InsertExercise(db, row, by);
  });
  if (!status.ok()) return status;
  return row;
}

Result<ExerciseRow> SqliteStore::ExerciseById(const Uuid& id) {
  return Read([&](Db& db) -> Result<ExerciseRow> {
    Query q(db,
            "SELECT id, name, version, title, content, scene, graded, published_ms FROM exercises "
            "WHERE tenant = ?1 AND id = ?2");
    return OneExercise(q.Bind(id), id.Text());
  });
}

Result<ExerciseRow> SqliteStore::ExerciseByContent(const Sha256& content) {
  return Read([&](Db& db) -> Result<ExerciseRow> {
    Query q(db,
            "SELECT id, name, version, title, content, scene, graded, published_ms FROM exercises "
            "WHERE tenant = ?1 AND content = ?2 ORDER BY version DESC LIMIT 1");
    return OneExercise(q.Bind(content), "with the content " + content.Hex());
  });
}

Result<std::vector<ExerciseRow>> SqliteStore::ExercisesFor(const Uuid& person) {
  return Read([&](Db& db) -> Result<std::vector<ExerciseRow>> {
    Query q(
        db,
        "SELECT e.id, e.name, e.version, e.title, e.content, e.scene, e.graded, e.published_ms "
        "FROM exercises e WHERE e.tenant = ?1 AND e.version = (SELECT max(version) FROM exercises "
        "n "
        "WHERE n.tenant = e.tenant AND n.name = e.name) AND EXISTS (SELECT 1 FROM assignments a "
        "WHERE a.tenant = e.tenant AND a.exercise_name = e.name AND (a.cohort = zeroblob(16) OR "
        "a.cohort IN (SELECT m.cohort FROM cohort_members m WHERE m.tenant = ?1 AND m.person = "
        "?2))) "
        "ORDER BY e.name");
    return ExercisesIn(q.Bind(person));
  });
}

Result<std::vector<ExerciseRow>> SqliteStore::AllExercises() {
  return Read([&](Db& db) -> Result<std::vector<ExerciseRow>> {
    Query q(db,
            "SELECT e.id, e.name, e.version, e.title, e.content, e.scene, e.graded, e.published_ms "
            "FROM exercises e WHERE e.tenant = ?1 AND e.version = (SELECT max(version) FROM "
            "exercises n "
            "WHERE n.tenant = e.tenant AND n.name = e.name) ORDER BY e.name");
    return ExercisesIn(q);
  });
}

}  // namespace enamel::server::sqlite
