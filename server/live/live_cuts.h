#pragma once

#include <map>
#include <tuple>
#include <vector>

#include "common/base/mutex.h"
#include "common/base/result.h"
#include "common/trace/trace.h"
#include "server/storage/recordings/recording_rows.h"

namespace enamel::server {

// Where the burs have been in an attempt, from its ticks: for each column of kCell_um along the scene's
// x and y, and each bur, the lowest place of the bur's tip while it pressed on something. Solid stops the bur, so
// it has cut the tooth down to there.
class CutColumns {
 public:
  static constexpr int32_t kCell_um = 250;  // half a small bur's width
  static constexpr int32_t kStep_um = 20;   // a column gets deeper by whole steps
  static constexpr size_t kMaxColumns = 4096;

  struct Column {
    int32_t x = 0, y = 0;   // whole kCell_um from the device's origin, the lower edge
    int32_t lowest_um = 0;  // from the device's origin
    uint32_t chunk = 0;     // that it was last lowered by
    size_t bur = 0;         // the number of the bur
  };

  // Requires: the chunk after those added before.
  void Add(const trace::Chunk& chunk);
  uint32_t chunks() const { return chunks_; }
  // Those that chunk `from` or a later one lowered.
  std::vector<Column> Since(uint32_t from) const;

 private:
  struct Lowest {
    int32_t um = 0;
    uint32_t chunk = 0;
  };
  uint32_t chunks_ = 0;
  std::map<std::tuple<int32_t, int32_t, size_t>, Lowest> columns_;
};

// The columns of attempts in progress that somebody asks for, read from the committed chunks: all of
// them once, then what came since. Of more than kMaxAttempts the one longest not asked for is
// forgotten, and read again when it is. Thread safety: any thread; one reads at a time.
class LiveCuts {
 public:
  static constexpr size_t kMaxAttempts = 128;

  struct Cut {
    uint32_t chunks = 0;  // that it was made of
    std::vector<CutColumns::Column> columns;
  };
  // Errors: those of the store, of DecodeChunk.
  Result<Cut> Get(RecordingRows& recordings, const Uuid& attempt, uint32_t from);

 private:
  struct Known {
    CutColumns columns;
    uint64_t asked = 0;
  };
  Status Read(RecordingRows& recordings, const Uuid& attempt, CutColumns& columns);

  Mutex mutex_;
  uint64_t asked_ ENAMEL_GUARDED_BY(mutex_) = 0;
  std::map<Uuid, Known> known_ ENAMEL_GUARDED_BY(mutex_);
};

}  // namespace enamel::server
