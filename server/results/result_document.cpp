#include "server/results/result_document.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <span>
#include <string>

namespace enamel::server {
namespace {

constexpr std::array<uint8_t, 4> kMagic = {'E', 'N', 'r', 'd'};
constexpr uint16_t kVersion = 1;
constexpr size_t kSignedBytes = 680, kBytes = kSignedBytes + 64;
constexpr char kDomain[] = "enamel.result-document.v1";

// Every hash and id in the order of the document, so that writing and reading cannot differ.
template <typename Document, typename Visit>
void ForEachHash(Document& d, const Visit& visit) {
  for (auto* hash :
       {&d.header, &d.recording, &d.exercise, &d.rubric, &d.scene, &d.volume, &d.profile}) {
    visit(hash->bytes);
  }
  visit(d.reference.bytes);
  for (auto* hash :
       {&d.reference_recording, &d.reference_tooth, &d.score_document, &d.tooth, &d.deviation,
        &d.series, &d.judgement, &d.score_file, &d.tooth_file, &d.surface_file, &d.series_file}) {
    visit(hash->bytes);
  }
}

Bytes SignedPart(const ResultDocument& d) {
  ByteWriter out;
  out.Raw(kMagic);
  out.U16(kVersion);
  out.Raw(d.attempt.view());
  out.I64(d.scored_ms);
  ForEachHash(d, [&](const auto& bytes) { out.Raw(bytes); });
  out.U64(std::bit_cast<uint64_t>(d.points));
  out.U8(d.critical_fail ? 1 : 0);
  for (uint32_t number : {d.metric_set, d.core_version, d.rubric_version, d.flags}) out.U32(number);
  out.U8(d.hand);
  out.Raw(d.key);
  ENAMEL_CHECK(out.size() == kSignedBytes);
  return out.Take();
}

void ReadInto(ByteReader& in, std::span<uint8_t> to) {
  ByteView from = in.Raw(to.size());
  if (from.size() == to.size()) std::ranges::copy(from, to.begin());
}

}  // namespace

void SignResult(ResultDocument& document, const trace::KeyPair& key) {
  document.key = key.public_key;
  document.signature = trace::SignText(kDomain, SignedPart(document), key.secret_key);
}

bool VerifyResult(const ResultDocument& document) {
  return trace::VerifyText(kDomain, SignedPart(document), document.signature, document.key);
}

Bytes EncodeResult(const ResultDocument& document) {
  Bytes out = SignedPart(document);
  out.insert(out.end(), document.signature.begin(), document.signature.end());
  return out;
}

Result<ResultDocument> DecodeResult(ByteView bytes) {
  ByteReader in(bytes);
  if (!std::ranges::equal(in.Raw(kMagic.size()), kMagic)) {
    return Status(Code::kInvalidInput, "result: expected one that begins with ENrd");
  }
  uint16_t version = in.U16();
  if (in.ok() && version != kVersion) {
    return Status(Code::kVersion, "result: version " + std::to_string(version) +
                                      ", this enamel-server reads " + std::to_string(kVersion) +
                                      "; run the newer one that wrote it");
  }
  if (bytes.size() != kBytes) {
    return Status(Code::kInvalidInput, "result: expected " + std::to_string(kBytes) +
                                           " bytes, found " + std::to_string(bytes.size()));
  }
  ResultDocument d;
  ReadInto(in, d.attempt.bytes);
  d.scored_ms = in.I64();
  ForEachHash(d, [&](auto& to) { ReadInto(in, to); });
  d.points = std::bit_cast<double>(in.U64());
  uint8_t failed = in.U8();
  d.critical_fail = failed != 0;
  for (uint32_t* number : {&d.metric_set, &d.core_version, &d.rubric_version, &d.flags}) {
    *number = in.U32();
  }
  d.hand = in.U8();
  ReadInto(in, d.key);
  ReadInto(in, d.signature);
  if (failed > 1 || !std::isfinite(d.points)) {
    return Status(Code::kInvalidInput, "result: expected a number of points and 0 or 1 for failed");
  }
  return d;
}

}  // namespace enamel::server
