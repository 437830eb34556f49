#pragma once

#include <functional>
#include <string>

#include "common/base/byte_pieces.h"
#include "common/base/result.h"
#include "server/results/result_files.h"
#include "server/storage/store.h"

// A score outside the house: the signed result of an attempt's newest run with the files that it
// binds (schemas/result.md, "Files"). Thread safety: functions, any thread; they block for the
// store.
namespace enamel::server {

// A recording as one trace file, also while it is made. The store outlives it.
Result<BytePieces> TraceFileOf(Store& store, const AttemptRow& row);

// Gives result.bin and each bound file that is kept, one after the other; what a retention rule
// removed is left out. `take` gets an error for a file that cannot be read (kConflict: the score was
// not signed), and ends the walk with one of its own. Errors: kConflict (no score yet), those of
// `take`. `surface` gives AttemptSurface's (stored_tooth.h): the caller bounds how many it makes at
// once, since each takes a core and the memory of a whole tooth.
Status ForEachResultFile(Store& store, const AttemptRow& row,
                         const std::function<Result<Bytes>(const AttemptResult&)>& surface,
                         const std::function<Status(std::string_view, Result<BytePieces>)>& take);

}  // namespace enamel::server
