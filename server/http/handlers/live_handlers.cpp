#include <algorithm>
#include <boost/json.hpp>

#include "common/base/unix_time.h"
#include "common/protocol/remark.h"
#include "server/http/caller.h"
#include "server/http/error_response.h"
#include "server/http/handlers/seen_attempt.h"
#include "server/http/json_body.h"
#include "server/http/operations.h"
#include "server/http/query.h"

// What was said to the chair of an attempt in progress, and where it has cut.
namespace enamel::server::http {
namespace json = boost::json;
namespace {

// Four bytes to a character; a longer text is refused by its characters.
constexpr size_t kMaxBytes = 4 * protocol::kMaxRemarkCharacters;

const char* NameOf(RemarkState state) {
  switch (state) {
    case RemarkState::kWaiting:
      return "waiting";
    case RemarkState::kSent:
      return "sent";
    case RemarkState::kShown:
      return "shown";
  }
  return "";
}

json::object SentJson(const ChairRemark& sent) {
  return {{"id", sent.id},
          {"text", sent.text},
          {"from", sent.from},
          {"sent_ms", sent.sent_ms},
          {"tick", sent.tick},
          {"state", NameOf(sent.state)},
          {"shown_ms", sent.shown_ms == 0 ? json::value() : json::value(sent.shown_ms)}};
}

// Anybody who may watch an attempt may send a remark. During an exam, only an instructor of the attempt's cohort may.
bool MaySpeak(const Call& call, const SeenAttempt& seen) {
  return !seen.row.exam || (call.caller->person.role == Role::kInstructor && seen.teaches);
}

Status MustBeMade(const AttemptRow& row, const char* instead) {
  if (row.state == AttemptState::kTicketed || row.state == AttemptState::kRecording) {
    return Status::Ok();
  }
  return Status(Code::kConflict, std::string("this attempt is not being made now, it is ") +
                                     AttemptStateName(row.state) + "; " + instead);
}

Status MustShow(const StationBoard& stations, const Uuid& station) {
  if (!stations.Connected(station)) {
    return Status(Code::kConflict,
                  "expected a station that is connected, this one is not; nothing was sent: try "
                  "again when it is back",
                  "station");
  }
  if (stations.ShowsRemarks(station)) return Status::Ok();
  return Status(Code::kConflict,
                "expected a station that shows remarks, this one's program is older; nothing was "
                "sent: have it updated",
                "station");
}

// The attempt's present tick: from the live state, else from the committed chunks.
uint64_t TickOf(const Call& call, const AttemptRow& row) {
  const uint64_t committed = row.ticks + row.gap_ticks;
  const std::optional<LiveSample> newest =
      call.live == nullptr ? std::nullopt : call.live->Latest(row.id);
  return newest ? std::max(newest->tick, committed) : committed;
}

Result<ChairRemark> Speak(const Call& call, Store& store, const std::string& given) {
  ENAMEL_ASSIGN_OR_RETURN(const auto seen, SeeAttempt(call, store, call.id));
  if (!MaySpeak(call, seen)) {
    return Status(Code::kForbidden,
                  "this is an exam: only instructors of this attempt's cohort can do this");
  }
  ENAMEL_ASSIGN_OR_RETURN(const std::string text, protocol::CheckedRemark(given));
  ENAMEL_RETURN_IF_ERROR(MustBeMade(seen.row, "write a remark on the attempt instead"));
  ENAMEL_RETURN_IF_ERROR(MustShow(*call.stations, seen.row.station));
  RemarkBoard& board = call.stations->remarks();
  ENAMEL_RETURN_IF_ERROR(board.Admit(call.id, enamel::UnixMs()));
  // Kept first: nothing is said at a chair that cannot be looked up afterwards.
  AnnotationRow kept;
  kept.attempt = call.id;
  kept.tick = TickOf(call, seen.row);
  kept.text = text;
  kept.to_chair = true;
  ENAMEL_ASSIGN_OR_RETURN(const auto row, store.remarks.AddAnnotation(kept, ActorOf(call)));
  const json::object about{{"annotation", row.id.Text()}, {"station", seen.row.station.Text()}};
  ENAMEL_RETURN_IF_ERROR(store.audit.NoteAudit(ActorOf(call), "attempt.speak", call.id.Text(),
                                               json::serialize(about)));
  const ChairRemark sent{call.id,  row.remark_id,  text, call.caller->person.display_name,
                         row.tick, row.created_ms, {},   {}};
  board.Put(sent);
  return sent;
}

Result<Response> NoStations() { return Status(Code::kNotFound, "this server accepts no stations"); }

}  // namespace

Result<Response> ListLiveRemarks(const Call& call, Store& store) {
  ENAMEL_ASSIGN_OR_RETURN(SeenAttempt seen, SeeAttempt(call, store, call.id));
  if (call.stations == nullptr) return NoStations();
  const std::vector<ChairRemark> all = call.stations->remarks().Of(call.id);
  json::array remarks;
  for (const ChairRemark& sent : all) remarks.push_back(SentJson(sent));
  const Uuid& station = seen.row.station;
  return JsonResponse({{"remarks", std::move(remarks)},
                       {"station",
                        {{"connected", call.stations->Connected(station)},
                         {"shows_remarks", call.stations->ShowsRemarks(station)}}},
                       {"allowed", MaySpeak(call, seen)},
                       {"max_characters", protocol::kMaxRemarkCharacters}});
}

Result<Response> SendLiveRemark(const Call& call, Store& store) {
  if (!IsJson(call.request)) return NotJson();
  BodyReader body(call.request);
  const std::string text = body.Text("text", 1, kMaxBytes);
  ENAMEL_RETURN_IF_ERROR(body.Finish());
  if (call.stations == nullptr) return NoStations();
  ENAMEL_ASSIGN_OR_RETURN(ChairRemark sent, Speak(call, store, text));
  return JsonResponse(SentJson(sent), 201);
}

Result<Response> GetLiveCut(const Call& call, Store& store) {
  ENAMEL_ASSIGN_OR_RETURN(uint64_t from, QueryOffset(call.request, "from"));
  ENAMEL_ASSIGN_OR_RETURN(SeenAttempt seen, SeeAttempt(call, store, call.id));
  ENAMEL_RETURN_IF_ERROR(MustBeMade(seen.row, "look at the attempt instead"));
  const auto first = static_cast<uint32_t>(std::min<uint64_t>(from, UINT32_MAX));
  ENAMEL_ASSIGN_OR_RETURN(LiveCuts::Cut cut, call.cuts->Get(store.recordings, call.id, first));
  json::array columns;
  for (const CutColumns::Column& column : cut.columns)
    columns.push_back(json::array{column.x, column.y, column.lowest_um, column.bur});
  return JsonResponse(
      {{"chunks", cut.chunks}, {"cell_um", CutColumns::kCell_um}, {"columns", std::move(columns)}});
}

}  // namespace enamel::server::http
