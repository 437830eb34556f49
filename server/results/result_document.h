#pragma once

#include <cstdint>

#include "common/trace/trace.h"
#include "server/training/types.h"

// The findings and inputs of a scoring run, signed by the server: schemas/result.md.
namespace enamel::server {

struct ResultDocument {
  Uuid attempt;
  UnixMs scored_ms = 0;
  Sha256 header, recording;  // of the recording: its header, its last chunk
  Sha256 exercise, rubric, scene, volume, profile;
  Uuid reference;  // zero: there was none
  Sha256 reference_recording, reference_tooth;
  Sha256 score_document, tooth, deviation, series;  // as the store names them
  Sha256 judgement;                                 // of points and reasons alone
  // Of the same four as their person gets them, not encrypted.
  Sha256 score_file, tooth_file, surface_file, series_file;
  double points = 0;
  bool critical_fail = false;
  uint32_t metric_set = 0, core_version = 0, rubric_version = 0;
  uint32_t flags = 0;  // of AttemptFlag, of kSignedFlags
  uint8_t hand = 0;    // schemas/result.md; 0: not told
  trace::PublicKey key{};
  trace::Signature signature{};

  bool operator==(const ResultDocument&) const = default;
};

// What the station or the clock says of an attempt; an excuse is people's.
inline constexpr uint32_t kSignedFlags = ~static_cast<uint32_t>(kExcused);

// Signs it with the key, which it then names.
void SignResult(ResultDocument& document, const trace::KeyPair& key);
// By the key that it names; whether that is the server's is for the caller to compare.
bool VerifyResult(const ResultDocument& document);

Bytes EncodeResult(const ResultDocument& document);
// Accepts only what EncodeResult writes. Does not check the signature. Errors: kInvalidInput,
// kVersion.
Result<ResultDocument> DecodeResult(ByteView bytes);

}  // namespace enamel::server
