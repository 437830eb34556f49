#include "tests/load/read_back.h"

#include <algorithm>

#include "server/app/data_folder.h"
#include "tests/server/storage/all_chunks.h"

namespace enamel::load {
namespace {

void Compare(const Station& station, const std::vector<Bytes>& stored, ReadBack& out) {
  const Recording& recording = *station.recording();
  std::vector<uint32_t> seen(recording.chunks(), 0);
  for (const Bytes& bytes : stored) {
    auto head = trace::DecodeChunkHead(bytes);
    uint32_t seq = head.ok() ? head->head.seq : UINT32_MAX;
    if (seq >= station.sent()) {
      out.ticks_doubled += head.ok() ? head->head.count : 0;
    } else if (bytes != recording.Chunk(seq)) {
      ++out.damaged_chunks;
    } else if (seen[seq]++ > 0) {
      out.ticks_doubled += recording.ticks(seq);
    } else {
      out.ticks_stored += recording.ticks(seq);
    }
  }
  for (uint32_t seq = 0; seq < station.committed(); ++seq) {
    if (seen[seq] == 0) out.ticks_lost += recording.ticks(seq);
  }
}

}  // namespace

Result<ReadBack> ReadEverythingBack(const std::filesystem::path& data,
                                    const std::vector<const Station*>& stations,
                                    const std::function<void(double)>& progress) {
  ENAMEL_ASSIGN_OR_RETURN(auto store, server::app::OpenForCommand(data));
  ReadBack out;
  for (size_t i = 0; i < stations.size(); ++i) {
    if (!stations[i]->recording()) continue;
    ENAMEL_ASSIGN_OR_RETURN(auto chunks,
                            AllChunks(store->recordings, stations[i]->recording()->attempt()));
    Compare(*stations[i], chunks, out);
    progress(static_cast<double>(i + 1) / static_cast<double>(stations.size()));
  }
  return out;
}

}  // namespace enamel::load
