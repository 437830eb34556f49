#include "server/jobs/score_job.h"

#include <algorithm>
#include <memory>
#include <string>

#include "common/base/unix_time.h"
#include "common/fidelity/cut_strokes.h"
#include "common/protocol/refusals.h"
#include "common/scene/attempt_documents.h"
#include "common/scene/json/json.h"
#include "common/scene/prepared_target.h"
#include "common/scene/volume_blob.h"
#include "common/scoring/movement/motion.h"
#include "common/scoring/movement/series.h"
#include "common/scoring/score.h"
#include "common/scoring/shape.h"
#include "common/scoring/task.h"
#include "common/scoring/trial.h"
#include "common/scoring/uncertainty.h"
#include "common/scoring/zones.h"
#include "common/surface/surface.h"
#include "common/timeline/deviation.h"
#include "common/trace/replay.h"
#include "server/jobs/judgement.h"
#include "server/jobs/regrade.h"
#include "server/jobs/surface_blob.h"
#include "server/results/result_document.h"

namespace enamel::server {
namespace {

// The newest of those before it: bounds what comparing costs.
constexpr uint32_t kMaxMotions = 500;

static_assert(ReferenceRows::kMaxCounting == scoring::kMaxEnvelopeMembers);

// Shares of a job's time, for its progress.
constexpr double kReplayFrom = 0.05, kReplayTo = 0.7, kMeasureTo = 0.95;

Status Differs(const std::string& what, const std::string& expected, const std::string& found) {
  return Status(Code::kConflict,
                what + ": expected " + expected + ", found " + found +
                    "; the recording does not belong to this attempt as it was issued");
}

Status Stopped() {
  return Status(Code::kUnavailable, "stopped: the job runs again after the next start");
}

// Not the place in the recording, which says little to its person.
Status AsUnreadable(const Status& status) {
  return status.ok() ? status : Status(status.code(), status.message(), protocol::kUnreadable);
}

// An instructor sets the score, or has the program mended.
Status WaitsForAPerson(const std::string& law) {
  return Status(Code::kInternal,
                "the score waits for a person: it breaks a law of grading (" + law +
                    "). Set a score by hand, and report this",
                protocol::kBrokenLaw);
}

// Farther than this from the pulp nobody asks how far.
constexpr double kFarFromPulp_m = 5e-3;

class ScoreJob {
 public:
  ScoreJob(Store& store, const Uuid& attempt, const Uuid& lease, const JobProgress& progress,
           ReferenceCache& cache, const trace::KeyPair* key)
      : store_(store),
        attempt_(attempt),
        lease_(lease),
        progress_(progress),
        cache_(cache),
        key_(key) {}

  Status Run() {
    ENAMEL_RETURN_IF_ERROR(AsUnreadable(LoadTrace()));
    ENAMEL_RETURN_IF_ERROR(AsUnreadable(CheckChain()));
    ENAMEL_RETURN_IF_ERROR(LoadDocuments());
    ENAMEL_RETURN_IF_ERROR(LoadReferences());
    ENAMEL_RETURN_IF_ERROR(Tell(kReplayFrom));
    core::Core core(header_.params, initial_);
    scoring::ProcessRecorder process(header_.params);
    moments_.emplace(initial_);
    scoring::SeriesRecorder series(header_.params, initial_.spec().voxel_m(), seal_.ticks);
    strokes_.emplace(header_.params);
    ENAMEL_RETURN_IF_ERROR(Replay(core, process, series));
    return Finish(at_limit_ ? *at_limit_ : core.volume(), process, series);
  }

 private:
  Status Tell(double progress) const {
    return progress_ && !progress_(progress) ? Stopped() : Status::Ok();
  }

  Status LoadTrace() {
    ENAMEL_ASSIGN_OR_RETURN(auto row, store_.attempts.AttemptById(attempt_));
    row_ = std::move(row);
    ENAMEL_ASSIGN_OR_RETURN(auto header, store_.recordings.AttemptHeader(attempt_));
    header_hash_ = HashSha256(header);
    ENAMEL_ASSIGN_OR_RETURN(auto decoded, trace::DecodeHeader(header));
    header_ = std::move(decoded);
    // Before anything is computed with them: a header may be well signed and still ask for the
    // impossible.
    ENAMEL_RETURN_IF_ERROR(core::ValidateParams(header_.params));
    ENAMEL_ASSIGN_OR_RETURN(auto seal, store_.recordings.AttemptSeal(attempt_));
    seal_ = seal;
    return Status::Ok();
  }

  Status CheckChain() const {
    if (header_.ticket.attempt != attempt_) {
      return Differs("attempt in the header", attempt_.Text(), header_.ticket.attempt.Text());
    }
    ENAMEL_ASSIGN_OR_RETURN(auto station, store_.stations.StationById(row_.station));
    trace::PublicKey key{};
    if (station.public_key.size() != key.size()) {
      return Status(Code::kInvalidInput, "station " + station.name + " has no valid public key");
    }
    std::copy(station.public_key.begin(), station.public_key.end(), key.begin());
    // Checked on arrival already. Checked again because the score uses what the disk returns now.
    ENAMEL_ASSIGN_OR_RETURN(const auto recording, store_.recordings.Open(attempt_));
    trace::ChainVerifier chain(attempt_, header_hash_);
    for (;;) {
      ENAMEL_ASSIGN_OR_RETURN(const auto bytes, recording.next());
      if (!bytes) return chain.AcceptSeal(seal_);
      if (!trace::VerifyChunk(*bytes, key)) {
        return Status(Code::kConflict, "chunk " + std::to_string(chain.next_seq()) +
                                           " is not signed by station " + station.name +
                                           ", which the attempt was recorded on");
      }
      ENAMEL_ASSIGN_OR_RETURN(auto chunk, trace::DecodeChunkHead(*bytes));
      ENAMEL_RETURN_IF_ERROR(chain.Accept(chunk));
    }
  }

  Status LoadDocuments() {
    const trace::Ticket& ticket = header_.ticket;
    if (ticket.exercise != row_.exercise_content) {
      return Differs("exercise", row_.exercise_content.Hex(), ticket.exercise.Hex());
    }
    if (ticket.profile != row_.profile_content) {
      return Differs("device profile", row_.profile_content.Hex(), ticket.profile.Hex());
    }
    auto documents = scene::ReadDocuments(ticket.exercise, ticket.profile, [&](const Sha256& hash) {
      return store_.blobs.GetBlob(hash);
    });
    ENAMEL_RETURN_IF_ERROR(documents.status());
    ENAMEL_RETURN_IF_ERROR(
        scene::CheckMadeOf(*documents, header_.scene, header_.volume, header_.params));
    exercise_ = std::move(documents->exercise);
    profile_ = std::move(documents->profile);
    scene_ = std::move(documents->scene);
    ENAMEL_RETURN_IF_ERROR(LoadRubric());
    return LoadVolume();
  }

  // The recording names the exercise's document, which never changes; a correction changes only how
  // it is judged.
  Status LoadRubric() {
    ENAMEL_ASSIGN_OR_RETURN(
        auto rubric, CountingRubric(store_.blobs, store_.rubrics, row_.exercise, exercise_.rubric));
    exercise_.rubric = std::move(rubric);
    return Status::Ok();
  }

  Status LoadVolume() {
    ENAMEL_ASSIGN_OR_RETURN(auto blob, store_.blobs.GetBlob(header_.volume));
    ENAMEL_ASSIGN_OR_RETURN(auto volume, scene::DecodeVolume(blob));
    initial_ = std::move(volume);
    return scene::LoadPreparedTarget(
        initial_, [&](const Sha256& hash) { return store_.blobs.GetBlob(hash); }, exercise_.target);
  }

  Status LoadReferences() {
    ENAMEL_ASSIGN_OR_RETURN(const auto rows, store_.references.Counting(row_.exercise));
    if (rows.empty()) {
      // Then the exercise's own target is all that an attempt is compared with.
      return Status::Ok();
    }
    for (const ReferenceRow& row : rows) {
      is_reference_ = is_reference_ || row.attempt == attempt_;
      ENAMEL_RETURN_IF_ERROR(row.attempt == attempt_ ? Status::Ok() : LoadReference(row.attempt));
    }
    return Status::Ok();
  }

  // One that cannot be read may be the one that this attempt follows, so nothing is scored without.
  Status LoadReference(const Uuid& attempt) {
    auto cut = cache_.Get(store_, attempt);
    if (!cut.ok()) {
      return Status(cut.status().code(), "the reference (attempt " + attempt.Text() +
                                             ") cannot be read: " + cut.status().message());
    }
    // What differs would be the teeth and not the cuts.
    if ((*cut)->initial_volume != header_.volume) {
      return Status(Code::kConflict, "the reference was cut from another volume (" +
                                         (*cut)->initial_volume.Hex() + ") than the attempt (" +
                                         header_.volume.Hex() + ")");
    }
    references_.push_back({attempt, *cut});
    return Status::Ok();
  }

  // With how far the bur's tip was from the pulp, where the tooth has one, and how right the device's force was.
  std::string SeriesText(const scoring::SeriesRecorder& series) {
    const auto felt_error = fidelity::FeltErrorOf(profile_, header_.params, *strokes_);
    const surface::Mesh pulp = scoring::PulpSurface(initial_);
    if (pulp.position_m.empty()) return series.ToJson({}, felt_error);
    const surface::DistanceQuery query(pulp);
    const auto pulp_m = [&](const dvec3& tip_m) {
      // Inside it is 0, and not how deep.
      if (initial_.TissueAtPoint(tip_m) == cutting::Tissue::kPulp) return 0.0;
      return query.Distance_m(tip_m, kFarFromPulp_m);
    };
    return series.ToJson(pulp_m, felt_error);
  }

  Status Replay(core::Core& core, scoring::ProcessRecorder& process,
                scoring::SeriesRecorder& series) {
    ENAMEL_ASSIGN_OR_RETURN(const auto recording, store_.recordings.Open(attempt_));
    auto report = trace::Replay(
        core, header_, recording.next, recording.chunks,
        [&](const trace::Tick& tick, const core::TickOutput& output) {
          // After an exam's limit the replay continues, to compare every witness to the end, and
          // nothing counts.
          if (at_limit_) return;
          process.Add(tick, output);
          series.Add(tick, output);
          strokes_->Add(tick.input, output.witness);
          moments_->Add(core.volume(), core.touched());
          time_ticks_ += 1 + tick.input.gap_ticks;
          if (row_.exam && row_.limit_ticks > 0 && time_ticks_ >= row_.limit_ticks) {
            at_limit_ = core.volume();
          }
        },
        [&](double done) { return Tell(kReplayFrom + (kReplayTo - kReplayFrom) * done).ok(); },
        // Nothing is scored then: hours of nonsense must not be computed to their last tick.
        trace::AfterDifference::kStop);
    ENAMEL_RETURN_IF_ERROR(report.status());
    report_ = std::move(report).value();
    if (report_.witness_ok) return Status::Ok();
    return Status(Code::kConflict,
                  "replay and recording part at tick " + std::to_string(report_.first_bad_tick) +
                      " (chunk " + std::to_string(report_.first_bad_chunk) + "): " + report_.what +
                      " differs. Nothing was scored. The station ran \"" +
                      header_.station_software + "\", core version " +
                      std::to_string(header_.params.core_version) +
                      "; check its memory and its software",
                  protocol::kReplay);
  }

  Status Finish(const cutting::Volume& final_volume, const scoring::ProcessRecorder& process,
                const scoring::SeriesRecorder& series) {
    const CelledSurface surface = CelledSurfaceOf(final_volume);
    scoring::AttemptData attempt{&initial_, &final_volume, &surface.mesh, &process};
    ENAMEL_RETURN_IF_ERROR(FindAcceptable(attempt));
    ENAMEL_ASSIGN_OR_RETURN(Judged judged, Judge(attempt));
    attempt.deviation_m = &judged.deviation_m;
    scoring::ScoreResult& score = judged.score;
    if (is_reference_) reference_attempt_ = attempt_;
    if (const Reference* by = judged.by->reference) {
      reference_attempt_ = by->attempt;
      reference_ = by->cut;
    }
    FillStation(process, score);
    const scoring::Provenance provenance = moments_->Take();
    score.deductions = scoring::FindDeductions(
        {&judged.by->r, &final_volume, &judged.found, &provenance, &process.strokes()});
    ENAMEL_RETURN_IF_ERROR(FillEnvelope(attempt, judged.by->data, judged.metrics, score));
    if (const std::string law = scoring::BrokenLaw(score); !law.empty())
      return WaitsForAPerson(law);

    AttemptResult result;
    result.shook = process.shook();
    result.borderline = !score.borderline.empty();
    result.score = score.score;
    result.critical_fail = score.critical_fail;
    result.reference = reference_attempt_;
    result.replay_realtime_factor = ReplayRealtimeFactor();
    std::string score_json = scoring::ToJson(score), series_json = SeriesText(series);
    // Blobs first, then one transaction that names them all: a crash in between leaves unnamed
    // blobs, which the next try writes again under the same names.
    const auto by_cell =
        timeline::DeviationOf(final_volume.spec(), surface.cell, judged.deviation_m);
    const Bytes tooth = scene::EncodeChange(final_volume, initial_, header_.volume),
                deviation = timeline::EncodeDeviation(by_cell);
    ENAMEL_RETURN_IF_ERROR(PutText(score_json, result.score_json));
    ENAMEL_RETURN_IF_ERROR(Put(tooth, result.final_volume));
    ENAMEL_RETURN_IF_ERROR(Put(deviation, result.deviation));
    ENAMEL_RETURN_IF_ERROR(PutText(series_json, result.series));
    // As it will be read: the document's numbers have fewer digits than the computed ones.
    ENAMEL_ASSIGN_OR_RETURN(auto stored, scoring::ScoreFromJson(score_json));
    const Sha256 judgement = JudgementOf(stored);
    result.same_judgement_as = SameAsBefore(judgement);
    ENAMEL_RETURN_IF_ERROR(FillMotion(process, result));
    if (key_ != nullptr) {
      ResultDocument document;
      document.judgement = judgement;
      document.score_file = HashSha256(AsBytes(score_json));
      document.tooth_file = HashSha256(tooth);
      document.surface_file = HashSha256(EncodeSurface(surface, by_cell));
      document.series_file = HashSha256(AsBytes(series_json));
      Sign(stored, document, result);
    }
    return store_.results.FinishAttempt(attempt_, result, lease_);
  }

  // Of several acceptable cuts the kindest judges the attempt: a student may follow any of the dentists, or the task as it
  // is written (schemas/score.md, "Acceptable cuts").
  struct Reference {
    Uuid attempt;
    std::shared_ptr<const ReferenceCut> cut;
  };
  struct Acceptable {
    const Reference* reference;  // null: the attempt itself, or the exercise's own target
    scoring::AttemptData data;
    scoring::AcceptableCut r;
    scoring::MeasuredCut cut;
  };
  struct Judged {
    const Acceptable* by = nullptr;
    scoring::FoundMistakes found;
    std::vector<float> deviation_m;
    scoring::MetricSet metrics;
    scoring::ScoreResult score;
  };

  Status AddAcceptable(const Reference* reference, const scoring::AttemptData& data,
                       const cutting::Volume& attempt) {
    ENAMEL_RETURN_IF_ERROR(Tell(kReplayTo));
    // A target that is a prepared tooth was laid on this one; what was cut here was not.
    const bool laid_on = data.process == nullptr && exercise_.target.prepared_tooth != nullptr;
    const scoring::ToothPlace place{scene_.tooth, scene_.up,
                                    laid_on ? scoring::kRegistration_m : 0};
    auto added = std::unique_ptr<Acceptable>(
        new Acceptable{reference, data, {initial_, *data.final_volume, place}, {}});
    ENAMEL_RETURN_IF_ERROR(Tell(kReplayTo));
    ENAMEL_ASSIGN_OR_RETURN(added->cut, scoring::MeasureCut(added->r, attempt, exercise_.rubric));
    acceptable_.push_back(std::move(added));
    return Status::Ok();
  }

  // A reference cut is compared with itself alone, so that its own figures can be looked at.
  Status FindAcceptable(const scoring::AttemptData& attempt) {
    const cutting::Volume& cut = *attempt.final_volume;
    if (is_reference_ || (row_.as_reference && references_.empty()))
      return AddAcceptable(nullptr, attempt, cut);
    for (const Reference& reference : references_) {
      const ReferenceCut& of = *reference.cut;
      ENAMEL_RETURN_IF_ERROR(
          AddAcceptable(&reference, {&initial_, &of.final_volume, &of.surface, &of.process}, cut));
    }
    ENAMEL_RETURN_IF_ERROR(Tell(kReplayTo));
    ENAMEL_ASSIGN_OR_RETURN(target_, scoring::ExactCut(scene_, exercise_, initial_));
    ENAMEL_RETURN_IF_ERROR(Tell(kReplayTo));
    target_surface_ = surface::ExtractSurface(target_);
    ENAMEL_RETURN_IF_ERROR(
        AddAcceptable(nullptr, {&initial_, &target_, &target_surface_, nullptr}, cut));
    // Equal: the newest reference.
    std::ranges::stable_sort(acceptable_, {}, [](const auto& a) { return a->cut.cost.sum; });
    return Status::Ok();
  }

  // By the kindest under which no error is critical; where each finds one, by the kindest.
  Result<Judged> Judge(const scoring::AttemptData& attempt) {
    std::optional<Judged> first;
    for (size_t i = 0; i < acceptable_.size(); ++i) {
      ENAMEL_ASSIGN_OR_RETURN(Judged judged,
                              JudgedBy(attempt, *acceptable_[i], i, acceptable_.size()));
      if (!judged.score.critical_fail) return judged;
      if (!first) first = std::move(judged);
    }
    return *std::move(first);
  }
  // `part` of `parts`: how far the measuring is.
  Result<Judged> JudgedBy(scoring::AttemptData attempt, const Acceptable& by, size_t part,
                          size_t parts) {
    auto tell = [&](double done) {
      const double all = (static_cast<double>(part) + done) / static_cast<double>(parts);
      return Tell(kReplayTo + (kMeasureTo - kReplayTo) * all);
    };
    ENAMEL_RETURN_IF_ERROR(tell(0));
    Judged out{&by, scoring::FindMistakes(by.r, by.cut.faults, by.cut.cost), {}, {}, {}};
    ENAMEL_RETURN_IF_ERROR(tell(0));
    out.deviation_m =
        scoring::DeviationPerVertex(*attempt.final_surface, initial_, *attempt.final_volume,
                                    *by.data.final_volume, *by.data.final_surface);
    attempt.deviation_m = &out.deviation_m;
    auto metrics = scoring::ComputeMetrics(
        scene_, exercise_, attempt, by.data, [&](double done) { return tell(done).ok(); },
        scoring::MetricPlan::For(exercise_.rubric));
    if (metrics.status().code() == Code::kUnavailable) return Stopped();
    ENAMEL_ASSIGN_OR_RETURN(out.metrics, std::move(metrics));
    ENAMEL_ASSIGN_OR_RETURN(out.score, scoring::ApplyRubric(exercise_.rubric, out.metrics,
                                                            by.cut.measures, out.found.mistakes));
    return out;
  }

  // The motion, and where it lies among those before it at the same exercise and the reference's.
  // One that cannot be read any more is left out.
  Status FillMotion(const scoring::ProcessRecorder& process, AttemptResult& result) {
    auto motion = scoring::MotionOf(process.samples());
    if (!motion) return Status::Ok();
    result.hand = scoring::FiguresOf(process);
    ENAMEL_RETURN_IF_ERROR(Put(scoring::EncodeMotion(*motion), result.motion));
    ENAMEL_ASSIGN_OR_RETURN(const auto rows, store_.motions.MotionsBefore(attempt_, kMaxMotions));
    // Preset paths are among all of them.
    std::vector<Uuid> whose, whose_preset;
    std::vector<scoring::Motion> others, presets;
    auto add = [&](const Uuid& attempt, const scoring::Motion& other, bool preset) {
      whose.push_back(attempt);
      others.push_back(other);
      if (!preset) return;
      whose_preset.push_back(attempt);
      presets.push_back(other);
    };
    // From the references' samples, which are in memory already.
    for (const Reference& reference : references_) {
      if (auto of = scoring::MotionOf(reference.cut->process.samples()))
        add(reference.attempt, *of, true);
    }
    for (const MotionRow& row : rows) {
      if (std::ranges::find(references_, row.attempt, &Reference::attempt) != references_.end()) {
        continue;
      }
      if (auto of = cache_.MotionIn(store_.blobs, row.content); of.ok())
        add(row.attempt, *of, row.preset);
    }
    const auto near = scoring::NearnessTo(*motion, others);
    if (!near) return Status::Ok();
    auto um = [](double m) { return static_cast<int64_t>(m * 1e6 + 0.5); };
    result.near = NearAttempt{whose[near->nearest], static_cast<uint32_t>(near->others),
                              um(near->nearest_m),  um(near->median_m),
                              um(near->size_m),     scoring::IsWorthALook(*near)};
    if (const auto preset = scoring::NearnessTo(*motion, presets)) {
      result.near->preset = whose_preset[preset->nearest];
      result.near->presets = static_cast<uint32_t>(preset->others);
      result.near->preset_um = um(preset->nearest_m);
    }
    return Status::Ok();
  }

  // The score document of the run before, if it has the same points and reasons. One that cannot be
  // read counts as another: an instructor then sees the new one before students do.
  std::optional<Sha256> SameAsBefore(const Sha256& judgement) const {
    auto before = store_.results.ResultOf(attempt_);
    if (!before.ok()) return std::nullopt;
    auto text = store_.blobs.GetBlob(before->score_json);
    if (!text.ok()) return std::nullopt;
    auto score = scoring::ScoreFromJson(AsText(*text));
    if (!score.ok() || JudgementOf(*score) != judgement) return std::nullopt;
    return before->score_json;
  }

  // `document` has the hashes of the files that are only stored encrypted.
  void Sign(const scoring::ScoreResult& score, ResultDocument document,
            AttemptResult& result) const {
    result.scored_ms = enamel::UnixMs();
    document.attempt = attempt_;
    document.scored_ms = result.scored_ms;
    document.header = header_hash_;
    document.recording = seal_.last_chunk;
    document.exercise = row_.exercise_content;
    document.rubric = HashSha256(AsBytes(scene::ToJson(exercise_.rubric)));
    document.scene = header_.scene;
    document.volume = header_.volume;
    document.profile = row_.profile_content;
    if (reference_attempt_) {
      document.reference = *reference_attempt_;
      document.reference_recording = reference_ ? reference_->recording : seal_.last_chunk;
      document.reference_tooth = reference_ ? reference_->tooth : result.final_volume;
    }
    document.score_document = result.score_json;
    document.tooth = result.final_volume;
    document.deviation = result.deviation;
    document.series = result.series;
    document.points = result.score;
    document.critical_fail = result.critical_fail;
    document.metric_set = static_cast<uint32_t>(score.scoring_version);
    document.core_version = score.core_version;
    document.rubric_version = static_cast<uint32_t>(score.rubric_version);
    document.flags = row_.flags & kSignedFlags & ~static_cast<uint32_t>(kShook | kBorderlineScore);
    if (result.shook) document.flags |= kShook;
    if (result.borderline) document.flags |= kBorderlineScore;
    if (!result.motion.IsZero()) {
      document.flags &= ~static_cast<uint32_t>(kNearAnother);
      if (result.near && result.near->worth_a_look) document.flags |= kNearAnother;
    }
    document.hand = static_cast<uint8_t>(header_.hand.kind);
    SignResult(document, *key_);
    result.document = EncodeResult(document);
  }

  void FillStation(const scoring::ProcessRecorder& process, scoring::ScoreResult& score) const {
    if (reference_attempt_) score.reference_attempt = reference_attempt_->Text();
    score.core_version = header_.params.core_version;
    score.ticks = report_.ticks;
    score.gap_ticks = report_.gap_ticks;
    score.late_ticks = process.late_ticks();
    score.bounded_ticks = process.bounded_ticks();
    score.outages = process.outages();
    score.disturbance = scoring::DisturbanceOf(process);
    score.witness_ok = report_.witness_ok;
  }

  // Where there is more than one reference.
  Status FillEnvelope(const scoring::AttemptData& attempt, const scoring::AttemptData& compared,
                      const scoring::MetricSet& metrics, scoring::ScoreResult& score) const {
    if (references_.size() + (is_reference_ ? 1 : 0) < 2) return Status::Ok();
    std::vector<scoring::EnvelopeMember> members;
    if (is_reference_) members.push_back({attempt_.Text(), attempt.final_volume, metrics});
    for (const Reference& reference : references_) {
      ENAMEL_RETURN_IF_ERROR(Tell(kMeasureTo));
      ENAMEL_ASSIGN_OR_RETURN(auto own, MetricsOf(reference.attempt, *reference.cut, compared));
      members.push_back({reference.attempt.Text(), &reference.cut->final_volume, std::move(own)});
    }
    ENAMEL_ASSIGN_OR_RETURN(score.envelope, scoring::PlaceInEnvelope(
                                                initial_, *attempt.final_volume, metrics, members));
    return Status::Ok();
  }

  // A reference measured as the attempt was: against the one that judged it, for the same rubric.
  Result<scoring::MetricSet> MetricsOf(const Uuid& member, const ReferenceCut& cut,
                                       const scoring::AttemptData& reference) const {
    const std::string key = member.Text() + " " +
                            (reference_attempt_ ? reference_attempt_->Text() : "target") + " " +
                            row_.exercise_content.Hex() + " " +
                            HashSha256(AsBytes(scene::ToJson(exercise_.rubric))).Hex();
    if (auto known = cache_.Metrics(key)) return *known;
    auto measured = scoring::ComputeMetrics(
        scene_, exercise_, {&initial_, &cut.final_volume, &cut.surface, &cut.process}, reference,
        {}, scoring::MetricPlan::For(exercise_.rubric));
    if (measured.ok()) cache_.KeepMetrics(key, *measured);
    return measured;
  }

  double ReplayRealtimeFactor() const {
    double recorded_s = static_cast<double>(report_.ticks) / header_.params.rate_hz;
    return report_.seconds > 0 ? recorded_s / report_.seconds : 0;
  }

  Status Put(ByteView bytes, Sha256& hash) {
    ENAMEL_ASSIGN_OR_RETURN(hash, store_.blobs.PutAttemptBlob(attempt_, bytes));
    return Status::Ok();
  }

  Status PutText(std::string_view text, Sha256& hash) {
    ENAMEL_ASSIGN_OR_RETURN(hash, store_.blobs.PutAttemptText(attempt_, text));
    return Status::Ok();
  }

  Store& store_;
  const Uuid attempt_, lease_;
  const JobProgress& progress_;
  ReferenceCache& cache_;
  const trace::KeyPair* const key_;  // null: the result is left unsigned

  AttemptRow row_;
  trace::Header header_;
  Sha256 header_hash_;
  trace::Seal seal_;
  scene::Scene scene_;
  scene::Exercise exercise_;
  scene::DeviceProfile profile_;
  std::optional<fidelity::CutStrokes> strokes_;
  cutting::Volume initial_;
  // The kindest first, once found; they point at the attempt's volume and surface.
  std::vector<std::unique_ptr<const Acceptable>> acceptable_;
  cutting::Volume target_;
  surface::Mesh target_surface_;
  std::vector<Reference> references_;  // those that count and are not this attempt, newest first
  bool is_reference_ = false;          // one that counts itself: compared with itself
  std::optional<Uuid> reference_attempt_;          // that judged it; none: there is no reference
  std::shared_ptr<const ReferenceCut> reference_;  // null: none, or itself
  trace::ReplayReport report_;
  std::optional<scoring::ProvenanceRecorder> moments_;
  uint64_t time_ticks_ = 0;                  // replayed, gaps included
  std::optional<cutting::Volume> at_limit_;  // of an exam: the tooth when its time was up
};

bool WorthAnotherTry(const Status& status) {
  return status.code() == Code::kStorage || status.code() == Code::kUnavailable;
}

}  // namespace

Status RunScoreJob(Store& store, const Uuid& attempt, const JobProgress& progress,
                   ReferenceCache* cache, const Uuid& lease, const trace::KeyPair* key) {
  ReferenceCache own;
  Status status = ScoreJob(store, attempt, lease, progress, cache ? *cache : own, key).Run();
  // Any other error would come again: the attempt states it, instead of the queue trying forever.
  if (status.ok() || WorthAnotherTry(status)) return status;
  return store.results.FailAttempt(attempt, status, lease);
}

}  // namespace enamel::server
