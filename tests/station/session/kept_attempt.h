#pragma once

#include <filesystem>
#include <string>

#include "common/scene/builtin/builtin.h"
#include "common/scene/json/json.h"
#include "common/scene/volume_blob.h"
#include "station/session/ticket_safe.h"
#include "station/uplink/blob_cache.h"
#include "station/uplink/credentials.h"

namespace enamel::station {

inline constexpr char kKeptPin[] = "804217";

// Documents of an attempt in a station's cache.
struct KeptDocuments {
  scene::Exercise exercise;
  Sha256 exercise_hash, profile_hash;
};

// A class I cavity in the practice block and a device profile, in the cache.
inline KeptDocuments KeepDocuments(const std::filesystem::path& data,
                                   const std::string& profile_name, bool graded) {
  auto built = scene::BuildBuiltinScene("block", 200'000);
  ENAMEL_CHECK(built.ok());
  BlobCache cache(data / "blobs");
  auto put = [&](ByteView bytes) {
    const Sha256 name = HashSha256(bytes);
    ENAMEL_CHECK(cache.Put(name, bytes).ok());
    return name;
  };
  ENAMEL_CHECK(put(scene::EncodeVolume(built->volume)) == built->scene.volume);
  const Sha256 scene_hash = put(AsBytes(scene::ToJson(built->scene)));
  KeptDocuments out;
  out.exercise = scene::ClassOneExercise(built->scene, scene_hash);
  out.exercise.graded = graded;
  // One to change to, with all that may be written of a bur.
  for (scene::BurSpec bur : built->scene.burs) {
    if (bur.name != "inverted-12") continue;
    bur.name.clear();
    bur.iso_number = "806 314 010 524 012";
    out.exercise.other_burs = {bur};
  }
  out.exercise_hash = put(AsBytes(scene::ToJson(out.exercise)));
  for (const scene::DeviceProfile& profile : scene::BuiltinProfiles()) {
    if (profile.name == profile_name) out.profile_hash = put(AsBytes(scene::ToJson(profile)));
  }
  return out;
}

// KeepDocuments' exercise, kept for later at a station: a ticket of this person signed by the
// server's key and locked under the PIN. An attempt can then be made without a server. Returns its
// id.
inline Uuid KeepAttempt(const std::filesystem::path& data, Spool& spool,
                        const Credentials& credentials, const trace::SecretKey& ticket_key,
                        const Uuid& person, const std::string& profile_name,
                        const std::string& pin) {
  const KeptDocuments documents = KeepDocuments(data, profile_name, true);
  trace::Ticket ticket;
  ticket.attempt = Uuid::New();
  ticket.person = person;
  ticket.station = credentials.station;
  ticket.expires_unix_ms = int64_t{1} << 60;
  ticket.exercise = documents.exercise_hash;
  ticket.profile = documents.profile_hash;
  trace::SignTicket(ticket, ticket_key);
  LockedTicket names;
  names.person = "Ada";
  names.exercise = documents.exercise.name;
  names.title = documents.exercise.title;
  names.profile = profile_name;
  ENAMEL_CHECK(TicketSafe(spool).Put(ticket, names, pin).ok());
  return ticket.attempt;
}

}  // namespace enamel::station
