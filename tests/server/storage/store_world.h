#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <string>

#include "common/trace/trace.h"
#include "server/storage/audit/actor.h"
#include "server/storage/judging/result_rows.h"
#include "server/storage/open_store.h"
#include "server/storage/recordings/ingest_rows.h"
#include "server/storage/store.h"
#include "tests/server/storage/all_chunks.h"
#include "tests/support/temp_folder.h"

// A data folder that goes away, and a small school in it: what storage, sign-in and station tests
// start from.
namespace enamel::server::testing {

using test::TempFolder;

inline const Actor kSystem{{}, "test"};

// Some chunks of a World: tests' recordings have parts, as long ones do.
inline constexpr size_t kSmallPart = 600;

inline std::unique_ptr<Store> OpenStore(const std::filesystem::path& folder,
                                        std::function<bool()> fail_next = {}) {
  StoreOptions options;
  options.folder = folder;
  options.fail_next = std::move(fail_next);
  options.trace_part_bytes = kSmallPart;
  auto store = OpenSqliteStore(options);
  EXPECT_TRUE(store.ok()) << store.status().message();
  return std::move(store).value();
}

inline Uuid AddPerson(Store& store, const std::string& login, Role role,
                      const std::string& verifier = "none") {
  Person person;
  person.login = login;
  person.display_name = "Name of " + login;
  person.role = role;
  auto id = store.people.CreatePerson(person, verifier, {}, kSystem);
  EXPECT_TRUE(id.ok()) << id.status().message();
  return *id;
}

inline Sha256 PutText(Store& store, const std::string& text) {
  return *store.blobs.PutBlob(AsBytes(text));
}

// Student, station with its key, scene, exercise, profile; attempts and chunks on request.
struct World {
  explicit World(Store& s) : store(s), keys(trace::NewKeyPair()) {
    student = AddPerson(store, "student", Role::kStudent);
    Sha256 code = HashSha256(AsBytes("code"));
    EXPECT_TRUE(store.stations.AddEnrolCode(code, 1000, kSystem).ok());
    StationRow row;
    row.name = "station";
    row.public_key.assign(keys.public_key.begin(), keys.public_key.end());
    station = store.stations.EnrolStation(code, row, HashSha256(AsBytes("credential")), 10)->id;
    scene = PutText(store, "scene");
    EXPECT_TRUE(
        store.scenes.PutScene({"scene", "Scene", scene, PutText(store, "volume")}, kSystem).ok());
    exercise = *store.exercises.PublishExercise(Exercise("exercise", "v1"), Uuid{}, kSystem);
    profile = PutText(store, "profile");
  }

  ExerciseRow Exercise(const std::string& name, const std::string& content) {
    ExerciseRow row;
    row.name = name;
    row.title = "Title of " + name;
    row.content = PutText(store, content);
    row.scene = scene;
    return row;
  }

  // Not stored.
  AttemptRow AttemptOf(const Uuid& person) const {
    AttemptRow row;
    row.id = Uuid::New();
    row.person = person;
    row.station = station;
    row.exercise = exercise.id;
    row.profile_content = profile;
    row.ticketed_ms = 5;
    return row;
  }
  AttemptRow NewAttempt() { return NewAttemptOf(student); }
  AttemptRow NewAttemptOf(const Uuid& person) {
    AttemptRow row = AttemptOf(person);
    EXPECT_TRUE(store.tickets.CreateAttempt(row, AsBytes("ticket"), kSystem).ok());
    return row;
  }

  Uuid OpenedAttempt() {
    AttemptRow row = NewAttempt();
    EXPECT_TRUE(store.tickets.OpenAttempt(row.id, AsBytes("header")).ok());
    return row.id;
  }

  // `salt` makes another content of the same chunk.
  ChunkPut Chunk(const Uuid& attempt, uint32_t seq, const Sha256& previous,
                 int32_t salt = 0) const {
    std::vector<trace::Tick> ticks(kTicksPerChunk);
    for (size_t i = 0; i < ticks.size(); ++i)
      ticks[i].input.counts[0] = static_cast<int32_t>(i) + salt;
    trace::ChunkHead head;
    head.attempt = attempt;
    head.seq = seq;
    head.first_tick = uint64_t{seq} * kTicksPerChunk;
    head.state_hash = 0xfedcba9876543210ull + seq;
    head.previous = previous;
    Bytes bytes = trace::EncodeChunk(head, ticks, keys.secret_key);
    auto decoded = trace::DecodeChunkHead(bytes);
    EXPECT_TRUE(decoded.ok()) << decoded.status().message();
    return {attempt, decoded->head, decoded->hash, std::move(bytes), 100};
  }

  static constexpr uint32_t kTicksPerChunk = 250;
  static Sha256 HeaderHash() { return HashSha256(AsBytes("header")); }

  // Appends `count` chunks and returns them.
  std::vector<ChunkPut> Append(const Uuid& attempt, uint32_t count) {
    std::vector<ChunkPut> out;
    Sha256 previous = HeaderHash();
    for (uint32_t seq = 0; seq < count; ++seq) {
      out.push_back(Chunk(attempt, seq, previous));
      Status status = store.ingest.AppendChunk(out.back());
      EXPECT_TRUE(status.ok()) << status.message();
      previous = out.back().hash;
    }
    return out;
  }

  static trace::Seal SealOf(const std::vector<ChunkPut>& chunks) {
    const auto& last = chunks.back();
    return {last.attempt, static_cast<uint32_t>(chunks.size()), chunks.size() * kTicksPerChunk,
            last.hash, last.head.state_hash};
  }

  // Sealed and scored without a reference.
  Uuid ScoredAttempt(double score = 80) { return Scored(OpenedAttempt(), score); }
  Uuid ScoredUnder(const Uuid& assignment) {
    AttemptRow row = AttemptOf(student);
    row.assignment = assignment;
    EXPECT_TRUE(store.tickets.CreateAttempt(row, AsBytes("ticket"), kSystem).ok());
    EXPECT_TRUE(store.tickets.OpenAttempt(row.id, AsBytes("header")).ok());
    return Scored(row.id, 80);
  }
  Uuid Scored(const Uuid& attempt, double score) {
    EXPECT_TRUE(store.seals.SealAttempt(SealOf(Append(attempt, 1)), 200).ok());
    AttemptResult result;
    result.score = score;
    result.score_json = PutText(store, "score");
    EXPECT_TRUE(store.results.FinishAttempt(attempt, result, {}).ok());
    return attempt;
  }

  Store& store;
  trace::KeyPair keys;
  Uuid student, station;
  Sha256 scene, profile;
  ExerciseRow exercise;
};

}  // namespace enamel::server::testing
