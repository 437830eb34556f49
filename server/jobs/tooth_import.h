#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "common/base/mutex.h"
#include "common/base/result.h"
#include "common/import/import_tooth.h"
#include "server/storage/audit/actor.h"
#include "server/storage/store.h"
#include "server/training/types.h"

namespace enamel::server {

// Makes a tooth from an uploaded mesh, as `enamel-station import` and `admin publish-scene` do
// (common/import/import_tooth.h reads it in the limited child): scene, volume and its exercises,
// assigned to nobody. Or only shows what would become of it, in coarser voxels, and stores nothing.
//
// The file comes in parts, in order, and waits on the disk; with its last byte a thread of its own begins to work. One at
// a time: it takes some hundred megabytes and a processor for up to some minutes. An upload without
// new bytes for kForgottenMs gives way to another. The outcome can be read until the next one
// begins, or the server ends. Until then, or until it is published, the file waits for being imported in another way. Thread safety: any thread. The destructor waits for the thread.
class ToothImport {
 public:
  static constexpr size_t kMaxFileBytes = size_t{128} << 20;
  static constexpr UnixMs kForgottenMs = 5 * 60'000;
  static constexpr int32_t kVoxelNm = 50'000, kShownVoxelNm = 100'000;

  struct Wanted {
    std::string kind;  // "stl", "ply", "obj", "off"
    uint64_t bytes = 0;
    std::string unit;       // of the coordinates: mm, um, cm, m, inch
    double scale = 1;       // how many of that unit a coordinate of 1 is
    double longest_mm = 0;  // of the file's box; decides instead of both (common/mesh/units.h)
    std::string title;
    int tooth = 0;  // FDI number (common/scene/tooth_number.h)
    // Occlusal and buccal direction in the file, or "auto" (common/import/place.h).
    std::string up = "auto", buccal = "auto";
    bool publish = true;    // false: only shown
    bool practice = false;  // its exercises are not graded
    // A dentist prepared the tooth of this exercise: the scan is laid on it, and becomes the target of a draft. Then title
    // and file decide alone; tooth and directions are the exercise's.
    std::optional<Uuid> prepared_of;
    bool placed = false;  // the scan is nearly in place already (import::PreparedOptions)
    bool jaw =
        false;  // the file holds several teeth: its surface is shown as it is, in mm along the file's axes
    import::GumCurves around;     // then: the curves along the gums (import::ImportOptions)
    std::optional<Uuid> mesh_of;  // the last import, of the same person: its file is taken again
  };
  enum class State { kReceiving, kWorking, kDone, kRefused };
  struct About {
    Uuid id;
    State state = State::kReceiving;
    uint64_t received = 0, bytes = 0;
    std::string phase;  // of the work, as import::ImportOptions::phase; empty: none yet
    double share = 0;   // of the phase "filling"
    std::vector<std::string> findings;           // once done: what was repaired and assumed
    std::optional<import::Placement> placement;  // once done, but for a target
    dvec3 size_mm{0};                            // once done: mesiodistal, buccolingual, height
    Status problem;                              // once refused
    std::optional<SceneRow>
        scene;  // once published, with its exercises; or a target's, with its draft
    std::vector<ExerciseRow> exercises;
  };

  // `child`: the mesh reader; empty: beside the running program.
  explicit ToothImport(Store& store, std::filesystem::path child = {});
  ~ToothImport();
  ToothImport(const ToothImport&) = delete;
  ToothImport& operator=(const ToothImport&) = delete;

  // Errors: kInvalidInput (kind, unit, title, tooth, no bytes; with field), kTooLarge, kUnavailable
  // while another is under way, kConflict with field "mesh_of" where the server no longer keeps that file.
  Result<About> Begin(const Wanted& wanted, const Actor& by, UnixMs now_ms);
  // The next bytes. Errors: kNotFound, kConflict with field "offset" where others are expected (the
  // message says which) or it is complete, kTooLarge.
  Result<About> Append(const Uuid& id, uint64_t offset, ByteView bytes, UnixMs now_ms);
  // Errors: kNotFound.
  Result<About> Get(const Uuid& id) const;
  // Errors: kNotFound, also where another person began it.
  Status MustBeOf(const Uuid& id, const Uuid& person) const;
  // Once shown: its surface (surface_blob.h), or what is inside of it (common/timeline/start_tooth.h).
  // Errors: kNotFound.
  enum class Picture { kSurface, kStartTooth };
  Result<std::shared_ptr<const Bytes>> PictureOf(const Uuid& id, Picture picture) const;
  // Forgets an upload that is not complete. Errors: kNotFound, kConflict once it is being worked
  // on.
  Status GiveUp(const Uuid& id);

 private:
  struct Made;
  class MeshFile;
  void Start() ENAMEL_REQUIRES(mutex_);
  void Work(const Wanted& wanted, std::shared_ptr<MeshFile> file, const Actor& by);
  Result<std::shared_ptr<MeshFile>> FileFor(Wanted& wanted, const Actor& by) const
      ENAMEL_REQUIRES(mutex_);
  Result<Made> Make(const Wanted& wanted, const MeshFile& file, const Actor& by);
  Result<Made> ShowJaw(const Wanted& wanted, const MeshFile& file);
  Result<Made> MakeTarget(const Wanted& wanted, const MeshFile& file, const Actor& by);
  Status Publish(const Wanted& wanted, const Actor& by, Made& made);
  Status MustBe(const Uuid& id) const ENAMEL_REQUIRES(mutex_);

  Store& store_;
  const std::filesystem::path child_;
  mutable Mutex mutex_;
  std::optional<About> about_ ENAMEL_GUARDED_BY(mutex_);
  std::shared_ptr<const Bytes> surface_ ENAMEL_GUARDED_BY(mutex_), inside_
      ENAMEL_GUARDED_BY(mutex_);
  Wanted wanted_ ENAMEL_GUARDED_BY(mutex_);
  Actor by_ ENAMEL_GUARDED_BY(mutex_);
  std::shared_ptr<MeshFile> file_ ENAMEL_GUARDED_BY(mutex_);
  UnixMs heard_ms_ ENAMEL_GUARDED_BY(mutex_) = 0;
  std::thread thread_ ENAMEL_GUARDED_BY(mutex_);
};

const char* StateName(ToothImport::State state);

}  // namespace enamel::server
