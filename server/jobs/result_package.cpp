#include "server/jobs/result_package.h"

#include <optional>
#include <string>

#include "common/scene/json/json.h"
#include "common/trace/trace.h"

namespace enamel::server {
namespace {

// The rubric that counted when it was scored: the exercise's own or a correction, today's or an
// earlier one.
Result<Bytes> RubricWithHash(Store& store, const AttemptRow& row, const ResultDocument& document) {
  auto text_of = [&](const scene::Rubric& rubric) -> std::optional<Bytes> {
    const std::string text = scene::ToJson(rubric);
    const ByteView bytes = AsBytes(text);
    if (HashSha256(bytes) != document.rubric) return std::nullopt;
    return Bytes(bytes.begin(), bytes.end());
  };
  ENAMEL_ASSIGN_OR_RETURN(const auto exercise_text, store.blobs.GetBlob(document.exercise));
  ENAMEL_ASSIGN_OR_RETURN(const auto exercise, scene::ExerciseFromJson(AsText(exercise_text)));
  if (auto text = text_of(exercise.rubric)) return *text;
  ENAMEL_ASSIGN_OR_RETURN(const auto corrections, store.rubrics.Rubrics(row.exercise));
  for (const RubricRow& correction : corrections) {
    ENAMEL_ASSIGN_OR_RETURN(const auto stored, store.blobs.GetBlob(correction.content));
    ENAMEL_ASSIGN_OR_RETURN(const auto rubric, scene::RubricFromJson(AsText(stored)));
    if (auto text = text_of(rubric)) return *text;
  }
  return Status(Code::kNotFound, "no rubric of the exercise is the one that the result names");
}

}  // namespace

Result<Bytes> TraceFileOf(Store& store, const AttemptRow& row) {
  ENAMEL_ASSIGN_OR_RETURN(auto header, store.recordings.AttemptHeader(row.id));
  ENAMEL_ASSIGN_OR_RETURN(auto chunks, store.recordings.AttemptChunks(row.id));
  // One by one: an unfinished attempt is still rows and no blob, and both become the same file.
  trace::TraceFile file{std::move(header), std::move(chunks), std::nullopt, false};
  if (auto seal = store.recordings.AttemptSeal(row.id); seal.ok()) file.seal = *seal;
  return trace::EncodeTraceFile(file);
}

Status ForEachResultFile(Store& store, const AttemptRow& row,
                         const std::function<Result<Bytes>(const AttemptResult&)>& surface,
                         const std::function<Status(std::string_view, Result<Bytes>)>& take) {
  ENAMEL_ASSIGN_OR_RETURN(const auto result, store.results.ResultOf(row.id));
  // Zero: that run made no such blob, or retention has removed it.
  auto blob = [&](std::string_view name, const Sha256& hash) {
    return hash.IsZero() ? Status::Ok() : take(name, store.blobs.GetBlob(hash));
  };
  const auto document = result.document.empty()
                            ? Status(Code::kConflict, "the score of attempt " + row.id.Text() +
                                                          " was not signed: have it scored again")
                            : DecodeResult(result.document);
  ENAMEL_RETURN_IF_ERROR(
      take(kResultFile, document.ok() ? Result<Bytes>(result.document) : document.status()));
  ENAMEL_RETURN_IF_ERROR(blob("score.json", result.score_json));
  ENAMEL_RETURN_IF_ERROR(blob("tooth.envb", result.final_volume));
  if (!result.deviation.IsZero()) {
    ENAMEL_RETURN_IF_ERROR(take("surface.ensf", surface(result)));
  }
  ENAMEL_RETURN_IF_ERROR(blob("forces.json", result.series));
  if (row.expired_ms == 0) {
    ENAMEL_RETURN_IF_ERROR(take("recording.entrace", TraceFileOf(store, row)));
  }
  if (!document.ok()) return Status::Ok();
  ENAMEL_RETURN_IF_ERROR(blob("exercise.json", document->exercise));
  ENAMEL_RETURN_IF_ERROR(blob("scene.json", document->scene));
  ENAMEL_RETURN_IF_ERROR(blob("start.envb", document->volume));
  ENAMEL_RETURN_IF_ERROR(blob("profile.json", document->profile));
  if (document->rubric.IsZero()) return Status::Ok();
  return take("rubric.json", RubricWithHash(store, row, *document));
}

}  // namespace enamel::server
