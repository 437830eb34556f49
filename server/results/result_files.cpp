#include "server/results/result_files.h"

#include <algorithm>
#include <array>

namespace enamel::server {
namespace {

// A recording is bound by its header and its last chunk.
constexpr std::string_view kRecording = "recording.entrace";

struct BoundFile {
  std::string_view name;
  Sha256 ResultDocument::*hash;
};
constexpr std::array<BoundFile, 10> kBound = {{{"score.json", &ResultDocument::score_file},
                                               {"tooth.envb", &ResultDocument::tooth_file},
                                               {"surface.ensf", &ResultDocument::surface_file},
                                               {"forces.json", &ResultDocument::series_file},
                                               {"exercise.json", &ResultDocument::exercise},
                                               {"rubric.json", &ResultDocument::rubric},
                                               {"scene.json", &ResultDocument::scene},
                                               {"start.envb", &ResultDocument::volume},
                                               {"profile.json", &ResultDocument::profile},
                                               {kRecording, &ResultDocument::recording}}};

Status Differs(const char* what, const std::string& is_signed, const std::string& found) {
  return Status(Code::kConflict,
                std::string(what) + " " + is_signed + " was signed, this one is " + found);
}

Status CheckRecording(const ResultDocument& d, ByteView bytes) {
  ENAMEL_ASSIGN_OR_RETURN(const auto file, trace::DecodeTraceFile(bytes));
  if (file.truncated || !file.seal) {
    return Status(Code::kConflict, "it ends before its seal: a part was cut off");
  }
  const Sha256 header = HashSha256(file.header);
  if (header != d.header) return Differs("header", d.header.Hex(), header.Hex());
  trace::ChainVerifier chain(d.attempt, header);
  for (const Bytes& bytes_of_chunk : file.chunks) {
    ENAMEL_ASSIGN_OR_RETURN(const auto chunk, trace::DecodeChunkHead(bytes_of_chunk));
    ENAMEL_RETURN_IF_ERROR(chain.Accept(chunk));
  }
  ENAMEL_RETURN_IF_ERROR(chain.AcceptSeal(*file.seal));
  if (chain.head() != d.recording) {
    return Differs("last chunk", d.recording.Hex(), chain.head().Hex());
  }
  return Status::Ok();
}

Status CheckFile(const ResultDocument& d, const BoundFile& bound, ByteView content) {
  if (bound.name == kRecording) return CheckRecording(d, content);
  const Sha256 found = HashSha256(content);
  if (found != d.*bound.hash) return Differs("SHA-256", (d.*bound.hash).Hex(), found.Hex());
  return Status::Ok();
}

}  // namespace

std::vector<std::string_view> BoundFileNames() {
  std::vector<std::string_view> out;
  for (const BoundFile& bound : kBound) out.push_back(bound.name);
  return out;
}

ResultCheck CheckResultFiles(const ResultDocument& document, const std::vector<ResultFile>& files) {
  ResultCheck out;
  for (const BoundFile& bound : kBound) {
    const auto file = std::ranges::find(files, bound.name, &ResultFile::name);
    if (file == files.end()) {
      out.not_there.emplace_back(bound.name);
    } else if (Status same = CheckFile(document, bound, file->content); same.ok()) {
      out.as_signed.push_back(file->name);
    } else {
      out.changed.push_back(file->name + ": changed, or of another result: " + same.message());
    }
  }
  return out;
}

}  // namespace enamel::server
