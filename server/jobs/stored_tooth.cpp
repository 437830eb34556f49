#include "server/jobs/stored_tooth.h"

#include "common/scene/volume_blob.h"
#include "common/timeline/deviation.h"
#include "server/jobs/surface_blob.h"
#include "server/results/result_document.h"

namespace enamel::server {

Result<cutting::Volume> StoredVolume(StoredBlobs& blobs, const Sha256& hash) {
  ENAMEL_ASSIGN_OR_RETURN(const auto blob, blobs.GetBlob(hash));
  return scene::DecodeVolume(blob);
}

Result<cutting::Volume> CutTooth(StoredBlobs& blobs, const Sha256& hash) {
  ENAMEL_ASSIGN_OR_RETURN(const auto blob, blobs.GetBlob(hash));
  ENAMEL_ASSIGN_OR_RETURN(const Sha256 from, scene::ChangedFrom(blob));
  ENAMEL_ASSIGN_OR_RETURN(const auto before, StoredVolume(blobs, from));
  return scene::DecodeChange(blob, before);
}

Result<Bytes> AttemptSurface(StoredBlobs& blobs, const AttemptResult& result) {
  ENAMEL_ASSIGN_OR_RETURN(const auto tooth, CutTooth(blobs, result.final_volume));
  ENAMEL_ASSIGN_OR_RETURN(const auto packed, blobs.GetBlob(result.deviation));
  ENAMEL_ASSIGN_OR_RETURN(const auto deviation, timeline::DecodeDeviation(packed));
  if (deviation.spec != tooth.spec()) {
    return Status(Code::kConflict, "the attempt's deviation has another grid than its tooth");
  }
  Bytes surface = EncodeSurface(CelledSurfaceOf(tooth), deviation);
  if (result.document.empty()) return surface;
  ENAMEL_ASSIGN_OR_RETURN(const auto document, DecodeResult(result.document));
  if (const Sha256 hash = HashSha256(surface); hash != document.surface_file) {
    return Status(Code::kConflict, "the surface made again has the hash " + hash.Hex() +
                                       ", the signed result names " + document.surface_file.Hex());
  }
  return surface;
}

}  // namespace enamel::server
