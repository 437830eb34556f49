#include "tests/load/recording_copy.h"

#include <algorithm>
#include <atomic>
#include <thread>

#include "tests/load/school.h"
#include "tests/load/stations/chunk_layout.h"

namespace enamel::load {

Result<trace::Seal> CopyRecording(server::Store& store, const CopyKeys& keys,
                                  const server::AttemptRow& row, trace::Header header,
                                  const std::vector<Bytes>& chunks, server::UnixMs received_ms) {
  header.ticket = {};
  header.ticket.attempt = row.id;
  header.ticket.person = row.person;
  header.ticket.station = row.station;
  header.ticket.exercise = row.exercise_content;
  header.ticket.profile = row.profile_content;
  header.ticket.expires_unix_ms = kFarOff;
  trace::SignTicket(header.ticket, keys.ticket.secret_key);
  ENAMEL_RETURN_IF_ERROR(
      store.tickets.CreateAttempt(row, trace::EncodeTicket(header.ticket), kLoadgen));
  const Bytes header_bytes = trace::EncodeHeader(header);
  ENAMEL_RETURN_IF_ERROR(store.tickets.OpenAttempt(row.id, header_bytes));
  trace::ChainVerifier chain(row.id, HashSha256(header_bytes));
  for (const Bytes& original : chunks) {
    ENAMEL_ASSIGN_OR_RETURN(auto decoded, trace::DecodeChunkHead(original));
    const Payload payload = PayloadOf(original);
    trace::ChunkHead head = decoded.head;
    head.attempt = row.id;
    head.previous = chain.head();
    const HeadBytes head_bytes = EncodeHead(head, payload);
    const trace::Signature signature =
        SignChunk(ChunkHash(head_bytes, payload), keys.station.secret_key);
    ByteWriter bytes;
    bytes.Raw(head_bytes);
    bytes.Raw(payload.packed);
    bytes.Raw(signature);
    server::ChunkPut put;
    put.attempt = row.id;
    put.bytes = bytes.Take();
    ENAMEL_ASSIGN_OR_RETURN(auto whole, trace::DecodeChunkHead(put.bytes));
    ENAMEL_RETURN_IF_ERROR(chain.Accept(whole));
    put.head = whole.head;
    put.hash = whole.hash;
    put.received_ms = received_ms;
    ENAMEL_RETURN_IF_ERROR(store.ingest.AppendChunk(put));
  }
  return chain.MakeSeal();
}

Status InParallel(size_t count, size_t threads, const std::function<Status(size_t)>& work) {
  std::atomic<size_t> next{0};
  std::vector<Status> outcomes(std::min(count, threads));
  {
    std::vector<std::jthread> runners;
    for (Status& outcome : outcomes) {
      runners.emplace_back([&] {
        for (size_t i; outcome.ok() && (i = next++) < count;) outcome = work(i);
      });
    }
  }
  for (const Status& outcome : outcomes) ENAMEL_RETURN_IF_ERROR(outcome);
  return Status::Ok();
}

}  // namespace enamel::load
