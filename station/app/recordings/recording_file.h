#pragma once

#include <filesystem>

#include "common/base/result.h"
#include "common/cutting/volume.h"
#include "common/trace/trace.h"

// An exported recording (`enamel-station spool export`) and its start tooth.
namespace enamel::station {

struct RecordingFile {
  trace::TraceFile file;
  trace::Header header;
};

// Errors: those of file reading and of the trace's readers.
Result<RecordingFile> ReadRecordingFile(const std::filesystem::path& path);

// Reads `volume`, or if that is empty, the station's cache under `data`. Errors: kConflict (the
// volume of another scene), kNotFound (neither exists), those of the volume's reader.
Result<cutting::Volume> ReadVolumeOf(const trace::Header& header,
                                     const std::filesystem::path& volume,
                                     const std::filesystem::path& data);

// Checks that the chunks form a chain and that the seal, if any, fits the last. Does not check
// signatures. Errors: kConflict with the expected and the found value.
Status CheckChain(const RecordingFile& recording);

}  // namespace enamel::station
