#include "server/storage/keys/envelope.h"

#include <sodium.h>

#include "common/base/check.h"

namespace enamel::server {

static_assert(kEnvelopeNonce == crypto_aead_xchacha20poly1305_ietf_NPUBBYTES);
static_assert(kEnvelopeTag == crypto_aead_xchacha20poly1305_ietf_ABYTES);

Bytes SealEnvelope(const EnvelopeHead& head, const DataKey& cipher,
                   const std::array<uint8_t, kEnvelopeNonce>& nonce, ByteView content) {
  ByteWriter writer;
  writer.Raw(AsBytes(head.magic));
  writer.U16(head.version);
  writer.U16(head.flags);
  writer.Raw(head.person.view());
  writer.Raw(nonce);
  Bytes out = writer.Take();
  out.resize(kEnvelopeBytes + content.size());
  unsigned long long size = 0;
  crypto_aead_xchacha20poly1305_ietf_encrypt(
      out.data() + kEnvelopeHead + kEnvelopeNonce, &size, content.data(), content.size(),
      out.data(), kEnvelopeHead, nullptr, nonce.data(), cipher.view().data());
  return out;
}

std::optional<EnvelopeHead> HeadOfEnvelope(ByteView sealed, std::string_view magic) {
  if (sealed.size() < kEnvelopeBytes || AsText(sealed.first(magic.size())) != magic) return {};
  ByteReader in(sealed.subspan(magic.size()));
  EnvelopeHead out;
  out.magic = magic;
  out.version = in.U16();
  out.flags = in.U16();
  out.person = Uuid::FromBytes(in.Raw(16));
  return out;
}

std::optional<Bytes> OpenEnvelope(ByteView sealed, const DataKey& cipher) {
  ENAMEL_CHECK(sealed.size() >= kEnvelopeBytes);
  Bytes out(sealed.size() - kEnvelopeBytes);
  const uint8_t* const nonce = sealed.data() + kEnvelopeHead;
  unsigned long long size = 0;
  if (crypto_aead_xchacha20poly1305_ietf_decrypt(out.data(), &size, nullptr, nonce + kEnvelopeNonce,
                                                 sealed.size() - kEnvelopeHead - kEnvelopeNonce,
                                                 sealed.data(), kEnvelopeHead, nonce,
                                                 cipher.view().data()) != 0) {
    return {};
  }
  return out;
}

}  // namespace enamel::server
