#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>

#include "common/base/bytes.h"
#include "common/base/uuid.h"
#include "server/storage/keys/data_key.h"

namespace enamel::server {

// The layout that personal data and wrapped keys have in common (schemas/personal_data.md): a head
// of magic, version, flags and person, a nonce, and XChaCha20-Poly1305 of the content with the head as
// additional data. Pure functions, any thread.
inline constexpr size_t kEnvelopeHead = 4 + 2 + 2 + 16, kEnvelopeNonce = 24, kEnvelopeTag = 16;
inline constexpr size_t kEnvelopeBytes =
    kEnvelopeHead + kEnvelopeNonce + kEnvelopeTag;  // when empty

struct EnvelopeHead {
  std::string_view magic;  // four characters
  uint16_t version = 0;
  Uuid person;
  uint16_t flags = 0;
};

Bytes SealEnvelope(const EnvelopeHead& head, const DataKey& cipher,
                   const std::array<uint8_t, kEnvelopeNonce>& nonce, ByteView content);
// None: too short, or of another magic. Nothing of it is proved yet.
std::optional<EnvelopeHead> HeadOfEnvelope(ByteView sealed, std::string_view magic);
// None: damaged, or sealed with another key. Requires: HeadOfEnvelope gave one.
std::optional<Bytes> OpenEnvelope(ByteView sealed, const DataKey& cipher);

}  // namespace enamel::server
