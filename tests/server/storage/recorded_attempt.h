#pragma once

#include <filesystem>
#include <map>

#include "server/storage/folder/ticket_key.h"
#include "tests/server/storage/store_world.h"

namespace enamel::server::testing {

// A data folder as left by a server: people, a station, documents, and recordings whose headers,
// tickets, signatures and chains are genuine, so that `verify` has everything to compare.
struct RecordedSchool {
  explicit RecordedSchool(const std::filesystem::path& data);

  // A ticketed and opened attempt of the student with so many chunks.
  Uuid Record(uint32_t chunks);
  Uuid RecordOf(const Uuid& person, uint32_t chunks);
  // One more chunk of an open attempt.
  Status Append(const Uuid& attempt);
  void Seal(const Uuid& attempt);
  // Seals and leaves a signed result, as the scoring job does; compared with `reference`, or with
  // nothing.
  void Score(const Uuid& attempt, const std::optional<Uuid>& reference = {});
  // Once more, with other points.
  void ScoreAgain(const Uuid& attempt, double points);
  Bytes TraceOf(const Uuid& attempt);  // as the store has it
  // What is scored from now on has a motion too.
  bool with_motion = false;

  std::filesystem::path data;
  std::unique_ptr<Store> store;
  World world;
  trace::KeyPair ticket_key = *ReadTicketKey(data);  // made when the store was opened

 private:
  void Finish(const Uuid& attempt, double points, const std::optional<Uuid>& reference);
  struct Chain {
    Sha256 head;
    std::vector<ChunkPut> chunks;
  };
  std::map<Uuid, Chain> chains_;
};

}  // namespace enamel::server::testing
