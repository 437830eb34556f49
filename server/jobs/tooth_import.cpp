#include "server/jobs/tooth_import.h"

#include <stdlib.h>

#include <algorithm>
#include <fstream>
#include <utility>

#include "common/import/mesh_kind.h"
#include "common/import/prepared_tooth.h"
#include "common/mesh/cut_out.h"
#include "common/mesh/units.h"
#include "common/scene/builtin/builtin.h"
#include "common/scene/json/json.h"
#include "common/scene/prepared_target.h"
#include "common/scene/tooth_number.h"
#include "common/scene/volume_blob.h"
#include "common/surface/surface.h"
#include "common/timeline/start_tooth.h"
#include "server/jobs/builtin_content.h"
#include "server/jobs/stored_tooth.h"
#include "server/jobs/surface_blob.h"
#include "server/training/names.h"

namespace enamel::server {
namespace {

namespace fs = std::filesystem;

constexpr double kMinPulp_mm3 = 0.5;  // a ball of 1 mm, which a bur can meet; chosen
// The default of `enamel-station target`.
constexpr int32_t kTargetLeeway_um = 250;
constexpr size_t kMaxNameBytes = 40;  // exercises put their kind before it

Status Invalid(const std::string& message, const char* field) {
  return Status(Code::kInvalidInput, message, field);
}

mesh::FileScale ScaleOf(const ToothImport::Wanted& wanted) {
  return {wanted.unit, wanted.scale, wanted.longest_mm};
}

Status CheckWanted(const ToothImport::Wanted& wanted) {
  if (const Status kind = import::CheckMeshKind(wanted.kind); !kind.ok())
    return Invalid(kind.message(), "file_name");
  ENAMEL_RETURN_IF_ERROR(mesh::CheckScale(ScaleOf(wanted)));
  ENAMEL_RETURN_IF_ERROR(CheckedName(wanted.title, "title").status());
  if (wanted.prepared_of && (wanted.jaw || !wanted.around.empty())) {
    return Invalid("expected the scan of one tooth for a target, found one of several teeth",
                   wanted.jaw ? "jaw" : "around");
  }
  if (wanted.jaw && (wanted.publish || !wanted.around.empty())) {
    return Invalid(
        "a scan of several teeth is only shown: expected `publish` false and no curves; then send "
        "the curves around a tooth without `jaw`",
        "jaw");
  }
  for (const auto& curve : wanted.around) ENAMEL_RETURN_IF_ERROR(mesh::Jaw::CheckCurve(curve));
  const bool one_tooth = !wanted.prepared_of && !wanted.jaw;
  if (one_tooth)
    ENAMEL_RETURN_IF_ERROR(import::CheckFacing({wanted.tooth, wanted.up, wanted.buccal}));
  if (one_tooth && !scene::IsToothNumber(wanted.tooth)) {
    return Invalid("expected the tooth's FDI number (ISO 3950), 11 to 48 or 51 to 85, found " +
                       (wanted.tooth == 0 ? "none" : std::to_string(wanted.tooth)),
                   "tooth");
  }
  if (wanted.bytes == 0)
    return Invalid("expected a file with something in it, found 0 bytes", "bytes");
  if (wanted.bytes <= ToothImport::kMaxFileBytes) return Status::Ok();
  return Status(Code::kTooLarge,
                "expected a file of at most " + std::to_string(ToothImport::kMaxFileBytes >> 20) +
                    " MiB, found one of " + std::to_string(wanted.bytes >> 20) +
                    " MiB: reduce the mesh in a mesh program (a crown needs no more than 200000 "
                    "triangles)",
                "bytes");
}

// Lower-case letters, digits and single hyphens of it; "tooth" where it has none, as of a name in
// another script.
std::string PlainName(std::string_view title, int tooth) {
  std::string out;
  for (char c : title) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
    const bool plain = (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9');
    if (plain && out.size() < kMaxNameBytes) out += c;
    if (!plain && !out.empty() && out.back() != '-') out += '-';
  }
  while (out.ends_with('-')) out.pop_back();
  const std::string number = std::to_string(tooth);
  if (out.empty()) out = "tooth";
  if (!out.ends_with(number)) out += "-" + number;
  return out;
}

// The name that is wanted, or with the first number with which no row has it.
template <typename Row>
std::string FreeName(const std::vector<Row>& rows, const std::string& wanted) {
  std::string name = wanted;
  for (int again = 2; std::ranges::find(rows, name, &Row::name) != rows.end(); ++again) {
    name = wanted + "-" + std::to_string(again);
  }
  return name;
}

// Exercises are named by their tooth, and another tooth is not a version of theirs.
Result<std::string> FreeToothName(SceneRows& scenes, const std::string& wanted) {
  ENAMEL_ASSIGN_OR_RETURN(const auto all, scenes.Scenes());
  return FreeName(all, wanted);
}

Result<std::string> FreeExerciseName(ExerciseRows& exercises, const std::string& wanted) {
  ENAMEL_ASSIGN_OR_RETURN(const auto all, exercises.AllExercises());
  return FreeName(all, wanted);
}

// Refuses a crown whose pulp a graded cut could hardly expose.
Status CheckPulp(const import::ImportedScene& imported) {
  constexpr auto kPulp = static_cast<size_t>(cutting::Tissue::kPulp);
  const double pulp_mm3 = cutting::SolidVolume_m3(imported.volume)[kPulp] * 1e9;
  if (pulp_mm3 >= kMinPulp_mm3) return Status::Ok();
  const dvec3& size = imported.size_mm;
  return Invalid("expected a pulp of at least " + mesh::Fixed(kMinPulp_mm3, 1) +
                     " mm3 for graded exercises, found " + mesh::Fixed(pulp_mm3, 1) +
                     " mm3 in a crown of " + mesh::Fixed(size.x, 1) + " x " +
                     mesh::Fixed(size.y, 1) + " x " + mesh::Fixed(size.z, 1) +
                     " mm: check its size, import its pulp as a part, or publish practice",
                 "practice");
}

// A scan as a picture of plaster, with the normals of its triangles' areas at each vertex.
surface::Mesh PlasterOf(const mesh::Triangles& scan) {
  surface::Mesh out;
  std::vector<dvec3> normals(scan.vertices.size(), dvec3(0));
  for (const auto& t : scan.indices) {
    const dvec3& a = scan.vertices[t[0]];
    const dvec3 area = glm::cross(scan.vertices[t[1]] - a, scan.vertices[t[2]] - a);
    for (uint32_t v : t) normals[v] += area;
  }
  for (size_t v = 0; v < normals.size(); ++v) {
    const double length = glm::length(normals[v]);
    out.position_m.emplace_back(scan.vertices[v] * 1e-3);
    out.normal.emplace_back(length > 0 ? normals[v] / length : dvec3(0, 0, 1));
  }
  out.tissue.assign(scan.vertices.size(), static_cast<uint8_t>(cutting::Tissue::kGypsum));
  out.triangles = scan.indices;
  return out;
}

}  // namespace

// A folder that only this account reads, with one file; gone with this. Written by one thread, then read by one.
class ToothImport::MeshFile {
 public:
  static Result<std::shared_ptr<MeshFile>> Make(const std::string& name) {
    std::error_code error;
    const fs::path temp = fs::temp_directory_path(error);
    std::string made = (temp / "enamel-mesh-XXXXXX").string();
    if (error || ::mkdtemp(made.data()) == nullptr) {
      return Status(Code::kStorage, "no folder for the mesh can be made in " + temp.string());
    }
    auto out = std::make_shared<MeshFile>(made, name);
    out->file_.open(out->path(), std::ios::binary);
    ENAMEL_RETURN_IF_ERROR(out->Written());
    return out;
  }
  MeshFile(fs::path folder, const std::string& name)
      : folder_(std::move(folder)), path_(folder_ / name) {}
  ~MeshFile() {
    std::error_code ignored;
    fs::remove_all(folder_, ignored);
  }
  MeshFile(const MeshFile&) = delete;
  MeshFile& operator=(const MeshFile&) = delete;

  const fs::path& path() const { return path_; }
  // Errors: kStorage, as of a disk that is full.
  Status Append(ByteView bytes) {
    file_.write(reinterpret_cast<const char*>(bytes.data()),
                static_cast<std::streamsize>(bytes.size()));
    file_.flush();
    return Written();
  }

 private:
  Status Written() const {
    if (file_) return Status::Ok();
    return Status(Code::kStorage, "the mesh cannot be written to " + path_.string());
  }
  const fs::path folder_, path_;
  std::ofstream file_;
};

struct ToothImport::Made {
  import::ImportedScene imported;
  bool is_tooth = true;           // in a stance of its own: no target, no jaw
  std::optional<SceneRow> scene;  // none: only shown
  std::vector<ExerciseRow> exercises;
  std::shared_ptr<const Bytes> surface, inside;

  void ShowVolume() {
    const cutting::Volume& volume = imported.volume;
    surface = std::make_shared<const Bytes>(EncodeSurface(surface::ExtractSurface(volume)));
    inside =
        std::make_shared<const Bytes>(timeline::EncodeStartTooth(timeline::StartToothOf(volume)));
  }
};

ToothImport::ToothImport(Store& store, std::filesystem::path child)
    : store_(store), child_(std::move(child)) {}

ToothImport::~ToothImport() {
  std::thread last;
  {
    MutexLock lock(mutex_);
    last = std::move(thread_);
  }
  if (last.joinable()) last.join();
}

Status ToothImport::MustBe(const Uuid& id) const {
  if (about_ && about_->id == id) return Status::Ok();
  return Status(Code::kNotFound, "this import does not exist; begin again");
}

// Named by us and not by the sender: the name appears in messages and in the provenance.
Result<std::shared_ptr<ToothImport::MeshFile>> ToothImport::FileFor(Wanted& wanted,
                                                                    const Actor& by) const {
  if (!wanted.mesh_of)
    return MeshFile::Make(PlainName(wanted.title, wanted.tooth) + "." + wanted.kind);
  if (!file_ || !about_ || about_->id != *wanted.mesh_of || by_.person != by.person)
    return Status(Code::kConflict, "the server no longer keeps that file: send it again",
                  "mesh_of");
  wanted.kind = wanted_.kind;
  wanted.bytes = wanted_.bytes;
  return file_;
}

void ToothImport::Start() {
  about_->state = State::kWorking;
  thread_ = std::thread([this, wanted = wanted_, file = file_, by = by_]() mutable {
    Work(wanted, std::move(file), by);
  });
}

Result<ToothImport::About> ToothImport::Begin(const Wanted& asked, const Actor& by, UnixMs now_ms) {
  ENAMEL_RETURN_IF_ERROR(CheckWanted(asked));
  Wanted wanted = asked;
  MutexLock lock(mutex_);
  if (about_) {
    const bool stale = about_->state == State::kReceiving && now_ms - heard_ms_ >= kForgottenMs;
    const bool over = about_->state == State::kDone || about_->state == State::kRefused;
    if (!stale && !over) {
      return Status(Code::kUnavailable,
                    "another tooth is being imported; try again when it is done");
    }
  }
  // Its last word was said under the lock: it is over, or about to be.
  if (thread_.joinable()) thread_.join();
  ENAMEL_ASSIGN_OR_RETURN(file_, FileFor(wanted, by));
  About fresh;
  fresh.id = Uuid::New();
  fresh.bytes = wanted.bytes;
  about_ = std::move(fresh);
  surface_ = inside_ = nullptr;
  wanted_ = std::move(wanted);
  by_ = by;
  heard_ms_ = now_ms;
  if (!wanted_.mesh_of) return *about_;
  about_->received = about_->bytes;
  Start();
  return *about_;
}

Result<ToothImport::About> ToothImport::Append(const Uuid& id, uint64_t offset, ByteView bytes,
                                               UnixMs now_ms) {
  MutexLock lock(mutex_);
  ENAMEL_RETURN_IF_ERROR(MustBe(id));
  if (about_->state != State::kReceiving || offset != about_->received) {
    return Status(Code::kConflict,
                  "expected the bytes from " + std::to_string(about_->received) +
                      " on, found those from " + std::to_string(offset),
                  "offset");
  }
  if (bytes.size() > about_->bytes - about_->received) {
    return Status(Code::kTooLarge,
                  "expected the " + std::to_string(about_->bytes) +
                      " announced bytes, found more; begin again",
                  "bytes");
  }
  ENAMEL_RETURN_IF_ERROR(file_->Append(bytes));
  about_->received += bytes.size();
  heard_ms_ = now_ms;
  if (about_->received < about_->bytes) return *about_;
  Start();
  return *about_;
}

Result<ToothImport::About> ToothImport::Get(const Uuid& id) const {
  MutexLock lock(mutex_);
  ENAMEL_RETURN_IF_ERROR(MustBe(id));
  return *about_;
}

Result<std::shared_ptr<const Bytes>> ToothImport::PictureOf(const Uuid& id, Picture picture) const {
  MutexLock lock(mutex_);
  ENAMEL_RETURN_IF_ERROR(MustBe(id));
  const auto& bytes = picture == Picture::kSurface ? surface_ : inside_;
  if (bytes) return bytes;
  return Status(Code::kNotFound, "expected an import that was shown and not published");
}

Status ToothImport::GiveUp(const Uuid& id) {
  MutexLock lock(mutex_);
  ENAMEL_RETURN_IF_ERROR(MustBe(id));
  if (about_->state != State::kReceiving) {
    return Status(Code::kConflict, "expected an upload that is not complete; this one is");
  }
  about_.reset();
  file_.reset();
  return Status::Ok();
}

Status ToothImport::MustBeOf(const Uuid& id, const Uuid& person) const {
  MutexLock lock(mutex_);
  return MustBe(by_.person == person ? id : Uuid{});
}

void ToothImport::Work(const Wanted& wanted, std::shared_ptr<MeshFile> file, const Actor& by) {
  Result<Made> made = Make(wanted, *file, by);
  file.reset();
  MutexLock lock(mutex_);
  about_->state = made.ok() ? State::kDone : State::kRefused;
  about_->phase.clear();
  if (!made.ok()) {
    about_->problem = made.status();
    return;
  }
  about_->findings = std::move(made->imported.report);
  if (made->is_tooth) about_->placement = std::move(made->imported.placement);
  about_->size_mm = made->imported.size_mm;
  surface_ = std::move(made->surface);
  inside_ = std::move(made->inside);
  about_->scene = std::move(made->scene);
  about_->exercises = std::move(made->exercises);
  if (about_->scene) file_.reset();
}

Result<ToothImport::Made> ToothImport::Make(const Wanted& wanted, const MeshFile& file,
                                            const Actor& by) {
  if (wanted.jaw) return ShowJaw(wanted, file);
  if (wanted.prepared_of) return MakeTarget(wanted, file, by);
  ENAMEL_ASSIGN_OR_RETURN(const std::string title, CheckedName(wanted.title, "title"));
  const std::string plain = PlainName(title, wanted.tooth);
  import::ImportOptions options;
  options.tooth = wanted.tooth;
  options.scale = ScaleOf(wanted);
  options.up = wanted.up;
  options.buccal = wanted.buccal;
  options.around = wanted.around;
  options.voxel_nm = wanted.publish ? kVoxelNm : kShownVoxelNm;
  options.name = plain;
  options.threads = 1;  // stations that stream want the other processors
  options.child = child_;
  options.phase = [this](std::string_view phase) {
    MutexLock lock(mutex_);
    about_->phase = phase;
    about_->share = 0;
  };
  options.progress = [this](double share) {
    MutexLock lock(mutex_);
    about_->share = share;
  };
  Made made;
  ENAMEL_ASSIGN_OR_RETURN(made.imported, import::ImportTooth(file.path(), options));
  if (wanted.publish) {
    ENAMEL_ASSIGN_OR_RETURN(made.imported.scene.name, FreeToothName(store_.scenes, plain));
    made.imported.scene.title = title;
    ENAMEL_RETURN_IF_ERROR(Publish(wanted, by, made));
  } else {
    if (const Status pulp = CheckPulp(made.imported); !pulp.ok())
      made.imported.report.push_back(pulp.message());
    made.ShowVolume();
  }
  made.imported.volume = {};
  return made;
}

Result<ToothImport::Made> ToothImport::ShowJaw(const Wanted& wanted, const MeshFile& file) {
  {
    MutexLock lock(mutex_);
    about_->phase = "reading";
  }
  ENAMEL_ASSIGN_OR_RETURN(const mesh::Triangles scan,
                          import::ReadJawScan(file.path(), ScaleOf(wanted), child_));
  Made made;
  made.is_tooth = false;
  made.imported.size_mm = mesh::BoxOf(scan).size();
  made.surface = std::make_shared<const Bytes>(EncodeSurface(PlasterOf(scan)));
  return made;
}

// A draft, because nobody has looked at its title, burs and rubric yet.
Result<ToothImport::Made> ToothImport::MakeTarget(const Wanted& wanted, const MeshFile& file,
                                                  const Actor& by) {
  ENAMEL_ASSIGN_OR_RETURN(const std::string title, CheckedName(wanted.title, "title"));
  ENAMEL_ASSIGN_OR_RETURN(const ExerciseRow row,
                          store_.exercises.ExerciseById(*wanted.prepared_of));
  ENAMEL_ASSIGN_OR_RETURN(const Bytes text, store_.blobs.GetBlob(row.scene));
  ENAMEL_ASSIGN_OR_RETURN(const scene::Scene tooth, scene::SceneFromJson(AsText(text)));
  ENAMEL_ASSIGN_OR_RETURN(const cutting::Volume whole, StoredVolume(store_.blobs, tooth.volume));
  {
    MutexLock lock(mutex_);
    about_->phase = "placing";
  }
  import::PreparedOptions options;
  options.scale = ScaleOf(wanted);
  options.placed = wanted.placed;
  ENAMEL_ASSIGN_OR_RETURN(auto taken,
                          import::TakePrepared(tooth, whole, file.path(), options, child_));
  Made made;
  made.is_tooth = false;
  made.imported = std::move(taken.prepared);
  scene::Scene& prepared = made.imported.scene;
  prepared.title = title;
  ENAMEL_ASSIGN_OR_RETURN(prepared.name, FreeToothName(store_.scenes, prepared.name));
  ENAMEL_ASSIGN_OR_RETURN(
      const auto target,
      scene::TargetFromPrepared(tooth, whole, made.imported.volume,
                                HashSha256(AsBytes(scene::ToJson(prepared))), kTargetLeeway_um));
  if (!wanted.publish) {
    made.ShowVolume();
    return made;
  }
  scene::Exercise exercise = scene::PreparedExercise(tooth, row.scene, target);
  exercise.title = title;
  // A tooth without a pulp has practice exercises only (CheckPulp).
  exercise.graded = row.graded && !wanted.practice;
  ENAMEL_ASSIGN_OR_RETURN(exercise.name, FreeExerciseName(store_.exercises, exercise.name));
  ENAMEL_ASSIGN_OR_RETURN(made.scene, StoreScene(store_.blobs, store_.scenes, prepared,
                                                 scene::EncodeVolume(made.imported.volume), by));
  ENAMEL_ASSIGN_OR_RETURN(const ExerciseRow document, StoreExercise(store_.blobs, exercise));
  ENAMEL_ASSIGN_OR_RETURN(const ExerciseRow draft, store_.exercises.PutDraft(document, by));
  made.exercises.push_back(draft);
  made.imported.volume = {};
  return made;
}

Status ToothImport::Publish(const Wanted& wanted, const Actor& by, Made& made) {
  const import::ImportedScene& imported = made.imported;
  if (!wanted.practice) ENAMEL_RETURN_IF_ERROR(CheckPulp(imported));
  ENAMEL_RETURN_IF_ERROR(PutFirstProfiles(store_));
  ENAMEL_ASSIGN_OR_RETURN(made.scene, StoreScene(store_.blobs, store_.scenes, imported.scene,
                                                 scene::EncodeVolume(imported.volume), by));
  ENAMEL_ASSIGN_OR_RETURN(made.exercises,
                          PublishExercisesOf(store_.blobs, store_.exercises, imported.scene,
                                             made.scene->content, by, wanted.practice));
  return Status::Ok();
}

const char* StateName(ToothImport::State state) {
  switch (state) {
    case ToothImport::State::kReceiving:
      return "receiving";
    case ToothImport::State::kWorking:
      return "working";
    case ToothImport::State::kDone:
      return "done";
    case ToothImport::State::kRefused:
      return "refused";
  }
  return "";
}

}  // namespace enamel::server
