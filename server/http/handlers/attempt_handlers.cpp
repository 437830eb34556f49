#include <boost/json.hpp>
#include <functional>

#include "common/scene/json/json.h"
#include "server/http/error_response.h"
#include "server/http/etag.h"
#include "server/http/handlers/seen_attempt.h"
#include "server/http/json_body.h"
#include "server/http/kept.h"
#include "server/http/operations.h"
#include "server/http/paging.h"
#include "server/http/query.h"
#include "server/http/site.h"
#include "server/http/tar.h"
#include "server/http/views/attempt_view.h"
#include "server/jobs/reference_check.h"
#include "server/jobs/result_package.h"
#include "server/jobs/stored_tooth.h"
#include "server/jobs/tick_window.h"
#include "server/training/access.h"
#include "server/training/names.h"
#include "server/training/ticket_rules.h"

namespace enamel::server::http {
namespace json = boost::json;
namespace {

constexpr size_t kMaxDentist = 200;

// The filters that are words.
Status NarrowByWords(const Call& call, AttemptFilter& filter) {
  const auto& query = call.request.query;
  if (auto word = query.find("state"); word != query.end()) {
    filter.state = AttemptStateFromName(word->second);
    if (!filter.state) return {Code::kInvalidInput, "expected the name of a state", "state"};
  }
  if (auto word = query.find("flag"); word != query.end()) {
    std::optional<AttemptFlag> flag = AttemptFlagFromName(word->second);
    if (!flag) return {Code::kInvalidInput, "expected the name of a flag", "flag"};
    filter.flags = *flag;
  }
  if (auto word = query.find("order"); word != query.end()) {
    using enum AttemptFilter::Order;
    const std::map<std::string, AttemptFilter::Order> orders{
        {"newest", kNewest}, {"name", kName}, {"lowest_score", kLowestScore}};
    const auto known = orders.find(word->second);
    if (known == orders.end()) {
      return {Code::kInvalidInput, "expected newest, name or lowest_score", "order"};
    }
    filter.order = known->second;
  }
  if (auto text = query.find("name"); text != query.end()) {
    if (text->second.size() > kMaxNameBytes) {
      return {Code::kInvalidInput, "expected at most " + std::to_string(kMaxNameBytes) + " bytes",
              "name"};
    }
    filter.name = text->second;
  }
  if (auto word = query.find("appeal"); word != query.end()) {
    if (word->second != "open") return {Code::kInvalidInput, "expected open", "appeal"};
    filter.open_appeal = true;
  }
  return {};
}

Result<AttemptFilter> FilterFor(const Call& call) {
  AttemptFilter filter;
  struct {
    const char* name;
    std::optional<Uuid>& into;
  } const ids[] = {
      {"person", filter.person},     {"cohort", filter.cohort},
      {"exercise", filter.exercise}, {"assignment", filter.assignment},
      {"before", filter.before},     {"cursor", filter.before}};  // its `next` is an id
  for (const auto& id : ids) {
    ENAMEL_ASSIGN_OR_RETURN(std::optional<Uuid> value, QueryId(call.request, id.name));
    // Two names fill one place; only one that was given may overwrite it.
    if (value) id.into = value;
  }
  ENAMEL_ASSIGN_OR_RETURN(uint32_t limit, QueryLimit(call.request, kDefaultPage, kMaxPage));
  filter.limit = limit;
  ENAMEL_RETURN_IF_ERROR(NarrowByWords(call, filter));

  const Person& viewer = call.caller->person;
  // Narrowed here and in the query itself, so that pages have the length asked for and nothing is
  // filtered out afterwards.
  if (viewer.role == Role::kStudent) {
    if ((filter.flags & kReviewFlags) != 0) {
      return Status{Code::kForbidden, "only people who review attempts can filter by this flag",
                    "flag"};
    }
    filter.person = viewer.id;
    // An order by scores would tell something of those that are not released.
    filter.order = AttemptFilter::Order::kNewest;
    // Their own attempts need no cohort, and one that they are not in would show them none.
    filter.cohort.reset();
  } else {
    NarrowToTaught(call, filter);
    filter.not_to_be_marked_by = viewer.id;
  }
  return filter;
}

// The results of the scoring job, for a caller who may see them now. Once a retention rule has
// removed the recording, only the score is left.
enum class Seen { kOwn, kOrAsReference };
Result<AttemptResult> SeeResult(const Call& call, Store& store, bool needs_recording,
                                Seen as = Seen::kOwn) {
  Result<SeenAttempt> seen = SeeAttempt(call, store, call.id);
  if (seen.status().code() == Code::kNotFound && as == Seen::kOrAsReference) {
    ENAMEL_ASSIGN_OR_RETURN(const bool reference, IsCallersReference(call, store, call.id));
    if (reference) return store.results.ResultOf(call.id);
  }
  ENAMEL_RETURN_IF_ERROR(seen.status());
  if (!CanSeeScore(call.caller->person, seen->row, seen->graded, seen->teaches)) {
    return Status{Code::kForbidden,
                  "this work is graded: the result shows after the instructor has released it"};
  }
  ENAMEL_RETURN_IF_ERROR(ScoreMustNotBeHidden(call, store, call.id));
  // After the right to see it: "not scored yet" is for people who may see the attempt.
  ENAMEL_RETURN_IF_ERROR(RequireScored(seen->row));
  if (needs_recording && seen->row.expired_ms != 0) {
    return Status{Code::kConflict, "the recording was removed on " +
                                       TimeText(seen->row.expired_ms) +
                                       " by a retention rule; the score stays"};
  }
  return store.results.ResultOf(call.id);
}

// What shows how a person moved: the browser may keep it until they sign out (SignOut), and asks each
// time, so that whoever may no longer see it gets nothing.
constexpr char kAskEachTime[] = "private, no-cache";

Result<Response> BlobResponse(const Call& call, Store& store, Sha256 AttemptResult::*member,
                              std::string content_type, Seen as = Seen::kOwn) {
  ENAMEL_ASSIGN_OR_RETURN(AttemptResult result,
                          SeeResult(call, store, member != &AttemptResult::score_json, as));
  const Sha256 content = result.*member;
  return KeptResponse(call.request, {content, std::move(content_type), kAskEachTime}, *call.bodies,
                      [&] { return store.blobs.GetBlob(content); });
}

// Errors: kUnavailable while it is being made, kNotFound when it could not be.
Result<Sha256> TimelineContent(const Uuid& attempt, TimelineRows& timelines) {
  ENAMEL_ASSIGN_OR_RETURN(const TimelineRow row, timelines.AskForTimeline(attempt));
  if (row.waits) {
    return Status{Code::kUnavailable,
                  "the playback of this attempt is being made; scores that people "
                  "wait for go first. Try again in a few minutes",
                  "playback_waits"};
  }
  if (row.content.IsZero()) {
    return Status{Code::kNotFound, "the playback of this attempt could not be made: " +
                                       row.problem + "; scoring the attempt again tries again"};
  }
  return row.content;
}

class LiveEvents final : public EventSource {
 public:
  LiveEvents(const Call& call, Store& store, std::unique_ptr<LiveWatch> watch)
      : store_(store),
        authenticator_(call.authenticator),
        // Not the caller, who ends with the request: a stream continues, and signing out ends it.
        token_hash_(call.caller->token_hash),
        attempt_(call.id),
        watch_(std::move(watch)) {}
  // Signed in, not disabled, and the attempt still the viewer's to see.
  bool StillAllowed() override {
    Result<Person> viewer = authenticator_.StillSignedIn(token_hash_);
    if (!viewer.ok() || viewer->role == Role::kStudent) return false;
    // A failure of the store ends the stream as well: showing on needs a yes.
    Result<AttemptRow> row = store_.attempts.AttemptById(attempt_);
    if (!row.ok()) return false;
    Result<bool> teaches = store_.attempts.Teaches(viewer->id, attempt_);
    return teaches.ok() && CanSeeAttempt(*viewer, *row, *teaches);
  }
  Event Take() override {
    Event event{watch_->Next()};
    // Next has seen both under one lock: no moment can come between the last one and the end.
    event.last = watch_->ended();
    return event;
  }

 private:
  Store& store_;
  auth::Authenticator& authenticator_;
  const Sha256 token_hash_;
  const Uuid attempt_;
  const std::unique_ptr<LiveWatch> watch_;
};

}  // namespace

Result<Response> ListAttempts(const Call& call, Store& store) {
  ENAMEL_ASSIGN_OR_RETURN(AttemptFilter filter, FilterFor(call));
  ENAMEL_ASSIGN_OR_RETURN(std::vector<AttemptRow> rows, store.attempts.Attempts(filter));
  AttemptView view(store, call.caller->person);
  json::array attempts;
  for (const AttemptRow& row : rows) {
    if (filter.taught_by) view.IsTaught(row);
    ENAMEL_ASSIGN_OR_RETURN(json::object attempt, view.Json(row));
    attempts.push_back(std::move(attempt));
  }
  json::value next;
  if (rows.size() == filter.limit) next = rows.back().id.Text();
  return JsonResponse({{"attempts", std::move(attempts)}, {"next", std::move(next)}});
}

Result<Response> GetAttempt(const Call& call, Store& store) {
  ENAMEL_ASSIGN_OR_RETURN(SeenAttempt seen, SeeAttempt(call, store, call.id));
  AttemptView view(store, call.caller->person);
  ENAMEL_ASSIGN_OR_RETURN(json::object attempt, view.DetailJson(seen.row));
  return WithETag(JsonResponse(attempt), seen.row.revision);
}

Result<Response> GetScore(const Call& call, Store& store) {
  return BlobResponse(call, store, &AttemptResult::score_json, "application/json");
}

// Of the surface that a tooth and a deviation give. Raise the number with any change of EncodeSurface: browsers keep
// what they have under this name.
Sha256 SurfaceName(const AttemptResult& result) {
  return HashSha256(AsBytes("surface 1 " + result.final_volume.Hex() + result.deviation.Hex()));
}

// Signed by the key that checks it, whoever keeps the file.
Result<Response> GetSignedResult(const Call& call, Store& store) {
  ENAMEL_ASSIGN_OR_RETURN(AttemptResult result, SeeResult(call, store, false));
  ENAMEL_ASSIGN_OR_RETURN(AttemptRow row, store.attempts.AttemptById(call.id));
  Tar tar(result.scored_ms / 1000);
  const auto surface = [&](const AttemptResult& of) -> Result<Bytes> {
    ENAMEL_ASSIGN_OR_RETURN(const auto made, call.bodies->Made(SurfaceName(of), [&] {
      return AttemptSurface(store.blobs, of);
    }));
    const ByteView bytes = AsBytes(*made);
    return Bytes(bytes.begin(), bytes.end());
  };
  const Status done = ForEachResultFile(store, row, surface,
                                        [&](std::string_view name, Result<BytePieces> content) {
                                          Status status = content.status();
                                          if (content.ok()) tar.Add(name, std::move(*content));
                                          return status;
                                        });
  // What is kept and cannot be read is damage of ours.
  if (!done.ok() && done.code() != Code::kConflict && done.code() != Code::kUnavailable) {
    return Status(Code::kInternal, done.message());
  }
  ENAMEL_RETURN_IF_ERROR(done);
  Response response;
  response.content_type = "application/x-tar";
  response.pieces = tar.Take();
  response.headers.emplace_back("Content-Disposition",
                                "attachment; filename=\"result-" + call.id.Text() + ".tar\"");
  return response;
}

// The store has no surface: the tooth and the deviation give it, and memory keeps it for a while.
Result<Response> GetSurface(const Call& call, Store& store) {
  ENAMEL_ASSIGN_OR_RETURN(AttemptResult result, SeeResult(call, store, true));
  return KeptResponse(
      call.request, {SurfaceName(result), "application/octet-stream", kAskEachTime, /*made=*/true},
      *call.bodies, [&] { return AttemptSurface(store.blobs, result); });
}

// Shown to whoever may see the surface, and, of a reference, to those whose own score was compared with it.
Result<Response> GetTimeline(const Call& call, Store& store) {
  ENAMEL_ASSIGN_OR_RETURN(AttemptResult result, SeeResult(call, store, true, Seen::kOrAsReference));
  ENAMEL_ASSIGN_OR_RETURN(Sha256 content, TimelineContent(call.id, store.timelines));
  return KeptResponse(call.request, {content, "application/octet-stream", kAskEachTime},
                      *call.bodies, [&] { return store.blobs.GetBlob(content); });
}

Result<Response> GetDeviation(const Call& call, Store& store) {
  return BlobResponse(call, store, &AttemptResult::deviation, "application/octet-stream");
}

// Anybody who is signed in: it belongs to nobody, and the timelines that begin with it name it.
Result<Response> GetStartTooth(const Call& call, Store& store) {
  const Status none{Code::kNotFound, "there is no such start tooth", "name"};
  Result<Sha256> content = Sha256::FromHex(call.name);
  if (!content.ok()) return none;
  // Before reading any blob: other blobs are named by their hash too.
  ENAMEL_ASSIGN_OR_RETURN(bool known, store.timelines.IsStartTooth(*content));
  if (!known) return none;
  return KeptResponse(
      call.request, {*content, "application/octet-stream", "private, max-age=31536000, immutable"},
      *call.bodies, [&] { return store.blobs.GetBlob(*content); });
}

Result<Response> GetSeries(const Call& call, Store& store) {
  return BlobResponse(call, store, &AttemptResult::series, "application/json",
                      Seen::kOrAsReference);
}

// Under the same conditions as the series: it is the same, closer.
Result<Response> GetTicks(const Call& call, Store& store) {
  ENAMEL_ASSIGN_OR_RETURN(uint64_t from, QueryOffset(call.request, "from"));
  ENAMEL_ASSIGN_OR_RETURN(uint64_t to, QueryOffset(call.request, "to"));
  if (!call.request.query.contains("to")) to = from + kMaxWindowTicks;
  if (Result<AttemptResult> seen = SeeResult(call, store, true); !seen.ok()) {
    return seen.status();
  }
  ENAMEL_ASSIGN_OR_RETURN(OpenRecording recording, store.recordings.Open(call.id));
  Result<std::string> ticks = TickWindowJson(recording.next, from, to);
  if (!ticks.ok()) {
    // Recordings are checked on arrival: an unreadable one is damage of ours.
    return ticks.status().field() == "to" ? ticks.status()
                                          : Status{Code::kInternal, ticks.status().message()};
  }
  Response response;
  response.content_type = "application/json";
  response.body = std::move(*ticks);
  return response;
}

Result<Response> ReleaseAttempt(const Call& call, Store& store) {
  ENAMEL_ASSIGN_OR_RETURN(SeenAttempt seen, SeeAttempt(call, store, call.id));
  if (!CanReleaseAttempt(call.caller->person, seen.row, seen.teaches)) {
    return Status(Code::kForbidden, "only instructors of this attempt's cohort can do this");
  }
  ENAMEL_RETURN_IF_ERROR(RequireScored(seen.row));
  // Nobody releases what has been scored again or overridden since they looked at it.
  ENAMEL_ASSIGN_OR_RETURN(int32_t revision, IfMatch(call.request));
  Status done = store.judging.ReleaseAttempt(call.id, ActorOf(call), revision);
  if (!done.ok()) return JudgedMeanwhile(call, store, done);
  return Done();
}

Result<Response> MakeReference(const Call& call, Store& store) {
  if (!IsJson(call.request)) return NotJson();
  BodyReader body(call.request);
  std::string dentist = body.Text("dentist", 1, kMaxDentist);
  bool consent = body.Flag("consent");
  std::string anyway;
  if (body.Has("anyway")) anyway = body.Text("anyway", 1, kMaxReasonBytes);
  ENAMEL_RETURN_IF_ERROR(body.Finish());
  ENAMEL_RETURN_IF_ERROR(CheckOneLine(anyway, "anyway"));
  // Before the attempt is looked up, since it holds for all of them.
  ENAMEL_RETURN_IF_ERROR(CheckConsent(consent));
  ENAMEL_ASSIGN_OR_RETURN(SeenAttempt seen, SeeAttempt(call, store, call.id));
  if (!CanMarkReference(call.caller->person, seen.row, seen.teaches)) {
    return Status(Code::kForbidden, "only instructors of this attempt's cohort can do this");
  }
  ENAMEL_RETURN_IF_ERROR(RequireScored(seen.row));
  ENAMEL_ASSIGN_OR_RETURN(ReferenceRow row, server::MakeReference(store, call.id, dentist, consent,
                                                                  anyway, ActorOf(call)));
  return JsonResponse(ReferenceJson(call.caller->person, row), 201);
}

// Other sites' pages cannot read the stream, and are not to begin one either.
Result<Response> GetLive(const Call& call, Store& store) {
  ENAMEL_RETURN_IF_ERROR(CheckSameSite(call.request));
  if (!call.live) return Status(Code::kNotFound, "this server shows nothing live");
  // Watches before reading its state, so that no end in between is missed.
  auto watch = call.live->Watch(call.id, call.caller->person.id);
  ENAMEL_ASSIGN_OR_RETURN(SeenAttempt seen, SeeAttempt(call, store, call.id));
  AttemptState state = seen.row.state;
  if (state != AttemptState::kTicketed && state != AttemptState::kRecording) {
    return Status(Code::kConflict, std::string("this attempt is not being made now, it is ") +
                                       AttemptStateName(state));
  }
  // Told last: whoever may not see it hears that and not how busy the server is.
  if (!watch) return call.live->WhyNot(call.caller->person.id);
  Response response;
  response.content_type = "text/event-stream";
  response.events = std::make_shared<LiveEvents>(call, store, std::move(watch));
  return response;
}

}  // namespace enamel::server::http
