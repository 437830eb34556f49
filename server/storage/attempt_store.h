#pragma once

#include <optional>
#include <vector>

#include "common/base/result.h"
#include "common/trace/trace.h"
#include "server/training/types.h"

namespace enamel::server {

struct AttemptFilter {
  std::optional<Uuid> person{};
  std::optional<Uuid> cohort{};                 // attempts of its students
  std::optional<Uuid> visible_to_instructor{};  // attempts in any cohort of this instructor
  std::optional<Uuid> exercise{};
  std::optional<Uuid> assignment{};
  std::optional<AttemptState> state{};
  uint32_t flags = 0;            // with all of these bits of AttemptFlag
  bool open_appeal = false;      // only those with an appeal that nobody has answered
  std::optional<Uuid> before{};  // page: ids lower than this (newest first)
  uint32_t limit = 50;           // at most 200
};

// A motion that is kept (schemas/motion.md). `content`: as BlobStore::PutAttemptBlob kept it.
struct MotionRow {
  Uuid attempt;
  Sha256 content;
};

// Where an attempt's motion lies among those before it (scoring::Nearness).
struct NearAttempt {
  Uuid attempt;  // the nearest; zero: it is erased
  uint32_t others = 0;
  int64_t nearest_um = 0, median_um = 0, size_um = 0;
  bool worth_a_look = false;  // kNearAnother

  bool operator==(const NearAttempt&) const = default;
};

// Reads attempts, their traces and their results.
// A part of Store (store.h), which says what holds for all parts.
class AttemptStore {
 public:
  virtual ~AttemptStore() = default;

  virtual Result<AttemptRow> AttemptById(const Uuid& id) = 0;
  virtual Result<std::vector<AttemptRow>> Attempts(const AttemptFilter& filter) = 0;
  virtual Result<Bytes> AttemptHeader(const Uuid& attempt) = 0;
  virtual Result<std::vector<Bytes>> AttemptChunks(const Uuid& attempt) = 0;
  // Of an attempt being made: the chunks that are committed from number `from` on, in order; of more than
  // `most` the newest. None once it is sealed.
  virtual Result<std::vector<Bytes>> NewestChunks(const Uuid& attempt, uint32_t from,
                                                  uint32_t most) = 0;
  virtual Result<trace::Seal> AttemptSeal(const Uuid& attempt) = 0;
  // What the job leaves: score JSON, final volume blob, page data (surface with deviation, force
  // series).
  struct AttemptResult {
    double score = 0;
    bool critical_fail = false;
    Sha256 score_json, final_volume, surface, series;
    std::optional<Uuid> reference;      // none when the exercise has no reference yet
    double replay_realtime_factor = 0;  // recorded time / replay time: of the machine, not the work
    UnixMs scored_ms = 0;               // 0: now
    Bytes document;                     // signed (schemas/result.md)
    // The score document of the run before, when it gives the same points for the same reasons:
    // then this is no other score, whatever else was measured.
    std::optional<Sha256> same_judgement_as;
    // The motion and what lies nearest to it: told to FinishAttempt, which sets or takes kNearAnother
    // by it, and not told back (NearestTo). Zero: none was measured, and what was found stays.
    Sha256 motion{};
    std::optional<NearAttempt> near{};  // none: there was none before it
  };
  virtual Result<AttemptResult> ResultOf(const Uuid& attempt) = 0;
  // Every run, newest first. Of earlier ones only the score and its reasons are kept.
  virtual Result<std::vector<ResultRow>> ResultsOf(const Uuid& attempt) = 0;
  // The chunks that contradict committed ones, as far as they were kept; by number.
  virtual Result<std::vector<ContradictionRow>> ContradictionsOf(const Uuid& attempt) = 0;
  // The motions at the same exercise, any version of it on the same scene, that were sealed before
  // this attempt's; the newest `limit`. Anybody's.
  virtual Result<std::vector<MotionRow>> MotionsBefore(const Uuid& attempt, uint32_t limit) = 0;
  // None when there was none before, or the recording is gone, or its score is from before this was
  // measured.
  virtual Result<std::optional<NearAttempt>> NearestTo(const Uuid& attempt) = 0;
};

}  // namespace enamel::server
