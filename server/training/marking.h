#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include "server/training/types.h"

namespace enamel::server {

// Several people mark the attempts of an assignment blind: schemas/marks.md, "Blind marking".
struct MarkingRow {
  Uuid id, assignment;
  UnixMs created_ms = 0;
  UnixMs ended_ms = 0;  // given up
  struct Marker {
    Uuid person;
    uint32_t marked = 0;
  };
  std::vector<Marker> markers;  // by id
  uint32_t works = 0;

  // All have marked all.
  bool done() const {
    return works > 0 &&
           std::ranges::all_of(markers, [&](const Marker& m) { return m.marked >= works; });
  }
};
// An attempt under the name that its markers see.
struct MarkingWork {
  Uuid id, marking, attempt;
};
struct BlindMark {
  Uuid work, marker;
  int32_t rating = 0;    // 1 clear fail … 5 excellent
  std::string criteria;  // JSON: [{"name", "points", "comment"}]
  UnixMs made_ms = 0;
};

}  // namespace enamel::server
