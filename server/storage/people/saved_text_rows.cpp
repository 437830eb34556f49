#include "server/storage/people/saved_text_rows.h"

#include <string>

#include "server/storage/audit/audit_trail.h"
#include "server/storage/audit/decisions.h"
#include "server/storage/engine/query.h"
#include "server/storage/engine/row_checks.h"

namespace enamel::server {
namespace {

#define ENAMEL_SAVED_TEXT_SELECT                                                         \
  "SELECT t.id, t.owner, p.display_name, t.text, t.shared, t.saved_ms, t.revision FROM " \
  "saved_texts t JOIN people p ON p.tenant = t.tenant AND p.id = t.owner WHERE t.tenant = ?1"

Result<SavedText> FindSavedText(Db& db, const Uuid& id) {
  Query q(db, ENAMEL_SAVED_TEXT_SELECT " AND t.id = ?2");
  return q.Bind(id).One<SavedText>("no saved text " + id.Text());
}

// That `row` fits beside the others. Its id counts, for one that replaces itself.
Status MustFit(Db& db, const SavedText& row) {
  Query own(db,
            "SELECT count(*), coalesce(max(CASE WHEN text = ?3 THEN 1 ELSE 0 END), 0) FROM "
            "saved_texts WHERE tenant = ?1 AND owner = ?2 AND id <> ?4");
  if (!own.Bind(row.owner, row.text, row.id).Next()) return own.status();
  if (own.Int(1) != 0) {
    return Status(Code::kConflict, "This text is saved already. Change it, or use the saved one.",
                  "text");
  }
  if (own.Int(0) >= SavedTextRows::kMaxOwn) {
    return Status(Code::kConflict,
                  "There are " + std::to_string(SavedTextRows::kMaxOwn) +
                      " saved texts, and no more fit. Remove one that you no longer use.",
                  "text");
  }
  if (!row.shared) return Status::Ok();
  Query shared(db,
               "SELECT count(*) FROM saved_texts WHERE tenant = ?1 AND shared = 1 AND id <> ?2");
  if (!shared.Bind(row.id).Next()) return shared.status();
  if (shared.Int(0) < SavedTextRows::kMaxShared) return Status::Ok();
  return Status(Code::kConflict,
                "The school shares " + std::to_string(SavedTextRows::kMaxShared) +
                    " texts, and no more fit. Save it for yourself, or have an administrator stop "
                    "sharing one.",
                "shared");
}

std::string SubjectOf(const SavedText& row) {
  return server::SubjectOf("saved_text", row.id.Text());
}

// Audit rows are about the owner, so that an erasure takes the words out of them.
std::string WordsOf(const SavedText& row) {
  return JsonOf({{"text", row.text}, {"shared", row.shared ? "yes" : "no"}});
}

}  // namespace

Result<std::vector<SavedText>> SavedTextRows::SavedTexts(const Uuid& person) {
  return rows_.Read([&](Db& db) -> Result<std::vector<SavedText>> {
    Query q(db, ENAMEL_SAVED_TEXT_SELECT
            " AND (t.owner = ?2 OR t.shared = 1) ORDER BY t.saved_ms DESC, t.id DESC");
    return q.Bind(person).All<SavedText>();
  });
}

Result<SavedText> SavedTextRows::SavedTextById(const Uuid& id) {
  return rows_.Read([&](Db& db) { return FindSavedText(db, id); });
}

Result<SavedText> SavedTextRows::AddSavedText(const SavedText& text, const Actor& by) {
  SavedText row = text;
  row.id = Uuid::New();
  row.owner = by.person;
  const Status status = rows_.Write([&](Db& db) -> Status {
    ENAMEL_RETURN_IF_ERROR(MustFit(db, row));
    ENAMEL_RETURN_IF_ERROR(Insert(db, "saved_texts", "id", row.id, "owner", row.owner, "text",
                                  row.text, "shared", row.shared, "saved_ms", NowMs()));
    return WriteAuditAbout(db, SubjectOf(row), by, "person.text_save", row.owner.Text(), "{}",
                           WordsOf(row));
  });
  ENAMEL_RETURN_IF_ERROR(status);
  return SavedTextById(row.id);
}

Result<SavedText> SavedTextRows::ReplaceSavedText(const SavedText& text, const Actor& by) {
  const Status status = rows_.Write([&](Db& db) -> Status {
    ENAMEL_ASSIGN_OR_RETURN(const SavedText stored, FindSavedText(db, text.id));
    ENAMEL_RETURN_IF_ERROR(MustBeRevision(stored.revision, text.revision));
    SavedText row = stored;
    row.text = text.text;
    row.shared = text.shared;
    ENAMEL_RETURN_IF_ERROR(MustFit(db, row));
    Query q(db,
            "UPDATE saved_texts SET text = ?3, shared = ?4, revision = revision + 1 WHERE tenant = "
            "?1 AND id = ?2");
    ENAMEL_RETURN_IF_ERROR(q.Bind(row.id, row.text, row.shared).Run());
    return WriteAuditAbout(db, SubjectOf(row), by, "person.text_edit", row.owner.Text(),
                           WordsOf(stored), WordsOf(row));
  });
  ENAMEL_RETURN_IF_ERROR(status);
  return SavedTextById(text.id);
}

Status SavedTextRows::DeleteSavedText(const Uuid& id, int32_t revision, const Actor& by) {
  return rows_.Write([&](Db& db) -> Status {
    ENAMEL_ASSIGN_OR_RETURN(const SavedText stored, FindSavedText(db, id));
    ENAMEL_RETURN_IF_ERROR(MustBeRevision(stored.revision, revision));
    Query q(db, "DELETE FROM saved_texts WHERE tenant = ?1 AND id = ?2");
    ENAMEL_RETURN_IF_ERROR(q.Bind(id).Run());
    return WriteAuditAbout(db, SubjectOf(stored), by, "person.text_remove", stored.owner.Text(),
                           WordsOf(stored), "{}");
  });
}

}  // namespace enamel::server
