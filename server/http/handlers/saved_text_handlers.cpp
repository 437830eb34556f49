#include <boost/json.hpp>

#include "server/http/error_response.h"
#include "server/http/etag.h"
#include "server/http/json_body.h"
#include "server/http/operations.h"
#include "server/http/paging.h"
#include "server/training/access.h"
#include "server/training/names.h"
#include "server/training/revision.h"

// What those who teach say again and again in remarks.
namespace enamel::server::http {
namespace json = boost::json;
namespace {

json::object SavedTextJson(const Call& call, const SavedText& row) {
  return {{"id", row.id.Text()},
          {"owner", {{"id", row.owner.Text()}, {"display_name", row.owner_name}}},
          {"text", row.text},
          {"shared", row.shared},
          {"saved_ms", row.saved_ms},
          {"mine", row.owner == call.caller->person.id},
          {"may_change", CanChangeSavedText(call.caller->person, row)},
          {"revision", row.revision}};
}

Result<SavedText> TextIn(const Call& call) {
  BodyReader body(call.request);
  SavedText row;
  row.text = body.Text("text", 1, kMaxRemarkBytes);
  row.shared = body.Flag("shared", false);
  ENAMEL_RETURN_IF_ERROR(body.Finish());
  return row;
}

// One that the caller may change.
Result<SavedText> OwnText(const Call& call, SavedTextRows& texts) {
  const Status none{Code::kNotFound, "there is no such saved text", "id"};
  Result<SavedText> row = texts.SavedTextById(call.id);
  if (!row.ok()) return row.status().code() == Code::kNotFound ? none : row.status();
  if (CanChangeSavedText(call.caller->person, *row)) return row;
  if (!CanUseSavedText(call.caller->person, *row)) return none;
  return Status{Code::kForbidden,
                "only its owner or an administrator may change a saved text; save one of your own "
                "instead"};
}

Result<Response> Refused(const Call& call, SavedTextRows& texts, const Status& status) {
  if (status.field() != kStale) return status;
  ENAMEL_ASSIGN_OR_RETURN(SavedText now, texts.SavedTextById(call.id));
  return Stale(status, SavedTextJson(call, now), now.revision);
}

}  // namespace

Result<Response> ListSavedTexts(const Call& call, Store& store) {
  ENAMEL_ASSIGN_OR_RETURN(Page page, PageOf(call.request, kMaxPage, kMaxPage));
  ENAMEL_ASSIGN_OR_RETURN(std::vector<SavedText> rows,
                          store.saved_texts.SavedTexts(call.caller->person.id));
  json::value next = CutPage(rows, page, [](const SavedText& row) {
    return FallingKey(static_cast<uint64_t>(row.saved_ms)) + row.id.Text();
  });
  json::array out;
  for (const SavedText& row : rows) out.push_back(SavedTextJson(call, row));
  return JsonResponse({{"texts", std::move(out)}, {"next", std::move(next)}});
}

Result<Response> AddSavedText(const Call& call, Store& store) {
  if (!IsJson(call.request)) return NotJson();
  ENAMEL_ASSIGN_OR_RETURN(SavedText text, TextIn(call));
  ENAMEL_ASSIGN_OR_RETURN(SavedText row, store.saved_texts.AddSavedText(text, ActorOf(call)));
  return WithETag(JsonResponse(SavedTextJson(call, row), 201), row.revision);
}

Result<Response> ReplaceSavedText(const Call& call, Store& store) {
  if (!IsJson(call.request)) return NotJson();
  ENAMEL_ASSIGN_OR_RETURN(SavedText stored, OwnText(call, store.saved_texts));
  ENAMEL_ASSIGN_OR_RETURN(int32_t revision, IfMatch(call.request));
  ENAMEL_ASSIGN_OR_RETURN(SavedText text, TextIn(call));
  text.id = call.id;
  text.revision = revision;
  Result<SavedText> row = store.saved_texts.ReplaceSavedText(text, ActorOf(call));
  if (!row.ok()) return Refused(call, store.saved_texts, row.status());
  return WithETag(JsonResponse(SavedTextJson(call, *row)), row->revision);
}

Result<Response> DeleteSavedText(const Call& call, Store& store) {
  ENAMEL_ASSIGN_OR_RETURN(SavedText stored, OwnText(call, store.saved_texts));
  ENAMEL_ASSIGN_OR_RETURN(int32_t revision, IfMatch(call.request));
  const Status done = store.saved_texts.DeleteSavedText(call.id, revision, ActorOf(call));
  return done.ok() ? Done() : Refused(call, store.saved_texts, done);
}

}  // namespace enamel::server::http
