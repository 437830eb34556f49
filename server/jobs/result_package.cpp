#include "server/jobs/result_package.h"

#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "common/scene/json/json.h"
#include "common/trace/pieces.h"

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

constexpr size_t kPieceBytes = size_t{1} << 20;

class TraceFilePieces {
 public:
  TraceFilePieces(ByteView header, OpenRecording recording, std::optional<trace::Seal> seal)
      : recording_(std::move(recording)), seal_(std::move(seal)) {
    trace::BeginTraceFile(header, piece_);
  }

  Result<Bytes> Next() {
    while (!ended_ && piece_.size() < kPieceBytes) {
      ENAMEL_ASSIGN_OR_RETURN(const auto chunk, recording_.next());
      if (chunk) trace::WriteChunk(*chunk, piece_);
      ended_ = !chunk;
      if (ended_ && seal_) trace::WriteSeal(*seal_, piece_);
    }
    return std::exchange(piece_, {}).Take();
  }

 private:
  OpenRecording recording_;
  std::optional<trace::Seal> seal_;
  ByteWriter piece_;
  bool ended_ = false;
};

}  // namespace

Result<BytePieces> TraceFileOf(Store& store, const AttemptRow& row) {
  ENAMEL_ASSIGN_OR_RETURN(const Bytes header, store.recordings.AttemptHeader(row.id));
  ENAMEL_ASSIGN_OR_RETURN(OpenRecording recording, store.recordings.Open(row.id));
  std::optional<trace::Seal> seal;
  if (recording.sealed) {
    ENAMEL_ASSIGN_OR_RETURN(seal, store.recordings.AttemptSeal(row.id));
  }
  BytePieces out;
  out.size = trace::TraceFileBytes(recording.bytes, recording.chunks, recording.sealed);
  out.held = 2 * kPieceBytes;
  auto pieces = std::make_shared<TraceFilePieces>(header, std::move(recording), std::move(seal));
  // A recording that cannot be read is refused before any part of it is sent.
  ENAMEL_ASSIGN_OR_RETURN(Bytes begin, pieces->Next());
  auto first = std::make_shared<Bytes>(std::move(begin));
  out.next = [pieces, first]() -> Result<Bytes> {
    return first->empty() ? pieces->Next() : Result<Bytes>(std::exchange(*first, {}));
  };
  return out;
}

Status ForEachResultFile(Store& store, const AttemptRow& row,
                         const std::function<Result<Bytes>(const AttemptResult&)>& surface,
                         const std::function<Status(std::string_view, Result<BytePieces>)>& take) {
  ENAMEL_ASSIGN_OR_RETURN(const auto result, store.results.ResultOf(row.id));
  // Zero: that run made no such blob, or retention has removed it.
  auto blob = [&](std::string_view name, const Sha256& hash) {
    return hash.IsZero() ? Status::Ok() : take(name, InOnePiece(store.blobs.GetBlob(hash)));
  };
  const auto document = result.document.empty()
                            ? Status(Code::kConflict, "the score of attempt " + row.id.Text() +
                                                          " was not signed: have it scored again")
                            : DecodeResult(result.document);
  ENAMEL_RETURN_IF_ERROR(take(kResultFile, document.ok()
                                               ? Result<BytePieces>(InOnePiece(result.document))
                                               : document.status()));
  ENAMEL_RETURN_IF_ERROR(blob("score.json", result.score_json));
  ENAMEL_RETURN_IF_ERROR(blob("tooth.envb", result.final_volume));
  if (!result.deviation.IsZero()) {
    ENAMEL_RETURN_IF_ERROR(take("surface.ensf", InOnePiece(surface(result))));
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
  return take("rubric.json", InOnePiece(RubricWithHash(store, row, *document)));
}

}  // namespace enamel::server
