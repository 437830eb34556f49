#pragma once

#include <filesystem>

#include "common/base/result.h"
#include "common/cutting/volume.h"
#include "common/trace/trace.h"

// An exported recording (`enamel-station spool export`) and the tooth it began with.
namespace enamel::station {

struct RecordingFile {
  trace::TraceFile file;
  trace::Header header;
};

// Errors: those of reading and of the trace's readers.
Result<RecordingFile> ReadRecordingFile(const std::filesystem::path& path);

// From `volume`, or, where that is empty, from the station's cache under `data`. Errors: kConflict
// (the volume of another scene), kNotFound (neither is there), what the volume's reader refuses.
Result<cutting::Volume> ReadVolumeOf(const trace::Header& header,
                                     const std::filesystem::path& volume,
                                     const std::filesystem::path& data);

// Whether the chunks follow one another and the seal, where there is one, fits the last. Signatures
// are not looked at. Errors: kConflict with what was expected and what was found.
Status CheckChain(const RecordingFile& recording);

}  // namespace enamel::station
