#include "station/app/recordings/recording_file.h"

#include <optional>

#include "common/base/file.h"
#include "common/scene/volume_blob.h"
#include "station/uplink/blob_cache.h"

namespace enamel::station {

namespace fs = std::filesystem;

Result<RecordingFile> ReadRecordingFile(const fs::path& path) {
  ENAMEL_ASSIGN_OR_RETURN(auto bytes, ReadFile(path));
  ENAMEL_ASSIGN_OR_RETURN(auto file, trace::DecodeTraceFile(bytes));
  ENAMEL_ASSIGN_OR_RETURN(auto header, trace::DecodeHeader(file.header));
  return RecordingFile{std::move(file), std::move(header)};
}

Result<cutting::Volume> ReadVolumeOf(const trace::Header& header, const fs::path& volume,
                                     const fs::path& data) {
  std::optional<Bytes> blob;
  if (!volume.empty()) {
    ENAMEL_ASSIGN_OR_RETURN(auto read, ReadFile(volume));
    // Reported here: in a replay on another tooth the first witness in contact would differ, as if
    // somebody had changed the recording.
    if (HashSha256(read) != header.volume) {
      return Status(Code::kConflict, volume.string() +
                                         " is not the volume this recording began with (" +
                                         header.volume.Hex() + "): it is of another scene");
    }
    blob = std::move(read);
  } else {
    blob = BlobCache(data / "blobs").Find(header.volume);
  }
  if (!blob) {
    return Status(Code::kNotFound, "the volume " + header.volume.Hex() + " is not in " +
                                       (data / "blobs").string() + ": name its file with --volume");
  }
  return scene::DecodeVolume(*blob);
}

Status CheckChain(const RecordingFile& recording) {
  trace::ChainVerifier chain(recording.header.ticket.attempt, HashSha256(recording.file.header));
  for (const Bytes& bytes : recording.file.chunks) {
    // The head is enough: the chain covers hashes of the bytes, and replay unpacks the ticks.
    ENAMEL_ASSIGN_OR_RETURN(auto chunk, trace::DecodeChunkHead(bytes));
    ENAMEL_RETURN_IF_ERROR(chain.Accept(chunk));
  }
  return recording.file.seal ? chain.AcceptSeal(*recording.file.seal) : Status::Ok();
}

}  // namespace enamel::station
