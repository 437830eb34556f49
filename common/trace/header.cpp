#include <sodium.h>

#include <algorithm>
#include <string>

#include "common/trace/layout.h"
#include "common/trace/trace.h"

// Ticket, header, seal and keys (schemas/trace_format.md).
namespace enamel::trace {
namespace {

constexpr std::string_view kTicketDomain = "enamel.attempt-ticket.v1";
constexpr size_t kTicketBytes = 214;

template <size_t N>
std::array<uint8_t, N> ReadArray(ByteReader& in) {
  std::array<uint8_t, N> out{};
  ByteView raw = in.Raw(N);
  std::copy(raw.begin(), raw.end(), out.begin());
  return out;
}

Uuid ReadUuid(ByteReader& in) { return {ReadArray<16>(in)}; }
Sha256 ReadHash(ByteReader& in) { return {ReadArray<32>(in)}; }

void WriteTicketFields(const Ticket& t, ByteWriter& out) {
  WriteMagic(kTicketMagic, out);
  out.Raw(t.attempt.view());
  out.Raw(t.nonce);
  out.Raw(t.person.view());
  out.Raw(t.station.view());
  out.Raw(t.exercise.view());
  out.Raw(t.profile.view());
  out.I64(t.issued_unix_ms);
  out.I64(t.expires_unix_ms);
}

void WriteHand(const Hand& hand, ByteWriter& out) {
  ENAMEL_CHECK(hand.kind != HandKind::kNotTold);
  out.U8(static_cast<uint8_t>(hand.kind));
  for (const std::string* text : {&hand.device, &hand.driver, &hand.unit}) {
    ENAMEL_CHECK(text->size() <= kMaxHandTextBytes);
    out.Text(*text);
  }
}

// The kind as recorded, which may be unknown.
uint8_t ReadHand(ByteReader& in, Hand& out) {
  const uint8_t kind = in.U8();
  out.kind = static_cast<HandKind>(kind);
  for (std::string* text : {&out.device, &out.driver, &out.unit}) {
    *text = in.Text(kMaxHandTextBytes);
  }
  return kind;
}

// The signed bytes: never valid as another kind of message.
std::string Message(std::string_view domain, ByteView content) {
  std::string message(domain);
  message += AsText(content);
  return message;
}

Bytes TicketFields(const Ticket& ticket) {
  ByteWriter fields;
  WriteTicketFields(ticket, fields);
  return fields.Take();
}

}  // namespace

Bytes EncodeTicket(const Ticket& ticket) {
  ByteWriter out;
  WriteTicketFields(ticket, out);
  out.Raw(ticket.signature);
  return out.Take();
}

Result<Ticket> DecodeTicket(ByteView bytes) {
  ByteReader in(bytes);
  ENAMEL_RETURN_IF_ERROR(ReadMagic("ticket", kTicketMagic, in));
  if (bytes.size() != kTicketBytes) return WrongSize("ticket", kTicketBytes, bytes.size());
  Ticket t;
  t.attempt = ReadUuid(in);
  t.nonce = ReadArray<16>(in);
  t.person = ReadUuid(in);
  t.station = ReadUuid(in);
  t.exercise = ReadHash(in);
  t.profile = ReadHash(in);
  t.issued_unix_ms = in.I64();
  t.expires_unix_ms = in.I64();
  t.signature = ReadArray<64>(in);
  return t;
}

Signature SignText(std::string_view domain, ByteView content, const SecretKey& key) {
  std::string message = Message(domain, content);
  Signature signature;
  crypto_sign_detached(signature.data(), nullptr, AsBytes(message).data(), message.size(),
                       key.data());
  return signature;
}

bool VerifyText(std::string_view domain, ByteView content, const Signature& signature,
                const PublicKey& key) {
  std::string message = Message(domain, content);
  return crypto_sign_verify_detached(signature.data(), AsBytes(message).data(), message.size(),
                                     key.data()) == 0;
}

void SignTicket(Ticket& ticket, const SecretKey& server_key) {
  ticket.signature = SignText(kTicketDomain, TicketFields(ticket), server_key);
}

bool VerifyTicket(const Ticket& ticket, const PublicKey& server_key) {
  return VerifyText(kTicketDomain, TicketFields(ticket), ticket.signature, server_key);
}

Bytes EncodeHeader(const Header& header) {
  ENAMEL_CHECK(header.station_software.size() <= kMaxSoftwareBytes);
  ByteWriter params;
  core::WriteParams(header.params, params);
  ByteWriter out;
  WriteMagic(kHeaderMagic, out);
  out.Blob(EncodeTicket(header.ticket));
  out.Raw(header.scene.view());
  out.Raw(header.volume.view());
  out.Blob(params.bytes());
  out.Text(header.station_software);
  WriteHand(header.hand, out);
  return out.Take();
}

Result<Header> DecodeHeader(ByteView bytes) {
  if (bytes.size() > kMaxHeaderBytes) return TooLarge("header", kMaxHeaderBytes, bytes.size());
  ByteReader in(bytes);
  ENAMEL_RETURN_IF_ERROR(ReadMagic("header", kHeaderMagic, in));
  ByteView ticket_bytes = in.Blob(kTicketBytes);
  Header h;
  h.scene = ReadHash(in);
  h.volume = ReadHash(in);
  ByteView params_bytes = in.Blob(core::kMaxParamsBytes);
  h.station_software = in.Text(kMaxSoftwareBytes);
  const uint8_t kind = ReadHand(in, h.hand);
  if (!in.ok()) return EndsEarly("header", bytes.size());
  ENAMEL_ASSIGN_OR_RETURN(auto ticket, DecodeTicket(ticket_bytes));
  h.ticket = ticket;
  ByteReader params_in(params_bytes);
  ENAMEL_ASSIGN_OR_RETURN(auto params, core::ReadParams(params_in));
  h.params = params;
  if (kind < 1 || kind > 3) {
    return Status(Code::kInvalidInput,
                  "header: expected a hand of kind 1 to 3, found " + std::to_string(kind), "hand");
  }
  // The one form (schemas/trace_format.md): chunk 0 names the header's hash, so two headers of one
  // content would be two recordings.
  Bytes again = EncodeHeader(h);
  if (!std::equal(again.begin(), again.end(), bytes.begin(), bytes.end())) {
    return Status(
        Code::kInvalidInput,
        "header: expected the one encoding of its content, found bytes left over or a field "
        "written in another way");
  }
  return h;
}

Bytes EncodeSeal(const Seal& seal) {
  ByteWriter out;
  WriteMagic(kSealMagic, out);
  out.Raw(seal.attempt.view());
  out.U32(seal.chunks);
  out.U64(seal.ticks);
  out.Raw(seal.last_chunk.view());
  out.U64(seal.state_hash);
  ENAMEL_CHECK(out.size() == kSealBytes);
  return out.Take();
}

Result<Seal> DecodeSeal(ByteView bytes) {
  ByteReader in(bytes);
  ENAMEL_RETURN_IF_ERROR(ReadMagic("seal", kSealMagic, in));
  if (bytes.size() != kSealBytes) return WrongSize("seal", kSealBytes, bytes.size());
  Seal s;
  s.attempt = ReadUuid(in);
  s.chunks = in.U32();
  s.ticks = in.U64();
  s.last_chunk = ReadHash(in);
  s.state_hash = in.U64();
  return s;
}

KeyPair NewKeyPair() {
  std::array<uint8_t, 32> seed;
  randombytes_buf(seed.data(), seed.size());
  // By way of a seed, so that the same code makes both kinds of pair.
  KeyPair pair = KeyPairFromSeed(seed);
  sodium_memzero(seed.data(), seed.size());
  return pair;
}

KeyPair KeyPairFromSeed(const std::array<uint8_t, 32>& seed) {
  KeyPair pair;
  ENAMEL_CHECK(
      crypto_sign_seed_keypair(pair.public_key.data(), pair.secret_key.data(), seed.data()) == 0);
  return pair;
}

}  // namespace enamel::trace
