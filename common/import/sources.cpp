#include "common/import/sources.h"

#include <algorithm>
#include <map>

#include "common/import/child_process.h"
#include "common/import/printable.h"

namespace enamel::import {
namespace {

namespace fs = std::filesystem;

// Pieces of names by which parts are known without being told.
struct KnownName {
  const char* piece;
  size_t layer;
};
constexpr std::array<KnownName, 5> kKnownNames = {
    {{"enamel", 0}, {"dentin", 1}, {"root", 1}, {"cement", 1}, {"pulp", 2}}};

std::string TissueOf(size_t layer) {
  return std::string(cutting::TissueName(kLayerTissues[layer]));
}

std::string Small(std::string text) {
  for (char& c : text) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  return text;
}

std::string NameOf(const mesh::MeshPart& part) {
  if (part.material.empty() || part.material == part.name) return part.name;
  return part.name + "/" + part.material;
}

std::string ListOf(const std::vector<mesh::MeshPart>& parts) {
  constexpr size_t kMost = 12;
  std::string out;
  for (size_t i = 0; i < std::min(parts.size(), kMost); ++i)
    out += (i > 0 ? ", '" : "'") + NameOf(parts[i]) + "'";
  return parts.size() > kMost ? out + " and " + std::to_string(parts.size() - kMost) + " more"
                              : out;
}

void Append(const mesh::Triangles& from, const mesh::MeshPart& part,
            std::optional<mesh::Triangles>& to) {
  if (!to) to.emplace();
  const auto shift = static_cast<uint32_t>(to->vertices.size());
  // Only the vertices that the part uses: the box of what is left must be the tissue's own.
  std::map<uint32_t, uint32_t> moved;
  for (uint32_t i = part.first; i < part.first + part.count; ++i) {
    std::array<uint32_t, 3> t;
    for (size_t k = 0; k < 3; ++k) {
      auto [it, fresh] =
          moved.emplace(from.indices[i][k], shift + static_cast<uint32_t>(moved.size()));
      if (fresh) to->vertices.push_back(from.vertices[from.indices[i][k]]);
      t[k] = it->second;
    }
    to->indices.push_back(t);
  }
}

class Reader {
 public:
  Reader(const ImportSources& sources, const fs::path& child) : sources_(sources), child_(child) {}

  Result<ReadSources> Run() {
    const bool named = std::any_of(sources_.tissues.begin(), sources_.tissues.end(),
                                   [](const std::string& s) { return !s.empty(); });
    if (!sources_.file.empty()) {
      if (Result<const mesh::NamedMesh*> mesh = File(sources_.file); !mesh.ok())
        return mesh.status();
    }
    if (!named) {
      if (sources_.file.empty())
        return Status(Code::kInvalidInput, "expected a mesh file, found none", "file");
      TakeWholeOrKnownParts();
      return std::move(out_);
    }
    for (size_t layer = 0; layer < kLayers; ++layer) {
      if (!sources_.tissues[layer].empty())
        ENAMEL_RETURN_IF_ERROR(Take(layer, sources_.tissues[layer]));
    }
    if (!sources_.file.empty() && !used_file_) ENAMEL_RETURN_IF_ERROR(TakeWholeAsEnamel());
    return std::move(out_);
  }

 private:
  Result<const mesh::NamedMesh*> File(const fs::path& file) {
    if (auto known = files_.find(file); known != files_.end()) return &known->second;
    ENAMEL_ASSIGN_OR_RETURN(auto read, ReadMeshInChild(file, child_));
    if (out_.name.empty()) out_.name = file.stem().string();
    out_.provenance += (out_.provenance.empty() ? "" : ", ") + Printable(file.filename().string()) +
                       " (SHA-256 " + read.sha256.Hex() + ")";
    out_.report.insert(out_.report.end(), read.mesh.notes.begin(), read.mesh.notes.end());
    return &files_.emplace(file, std::move(read.mesh)).first->second;
  }

  // A whole crown beside files of what is in it.
  Status TakeWholeAsEnamel() {
    if (out_.surfaces[0]) {
      return Status(Code::kInvalidInput,
                    "expected tissues that are parts of " + sources_.file.filename().string() +
                        ", or it alone as the enamel; every tissue names another file",
                    "file");
    }
    out_.surfaces[0] = files_.at(sources_.file).mesh;
    out_.report.push_back("enamel: the whole of " + Printable(sources_.file.filename().string()));
    return Status::Ok();
  }

  void TakeWholeOrKnownParts() {
    const mesh::NamedMesh& mesh = files_.at(sources_.file);
    std::array<std::vector<const mesh::MeshPart*>, kLayers> found;
    std::vector<mesh::MeshPart> others;
    for (const mesh::MeshPart& part : mesh.parts) {
      const std::string name = Small(NameOf(part));
      auto known = std::find_if(kKnownNames.begin(), kKnownNames.end(), [&](const KnownName& k) {
        return name.find(k.piece) != std::string::npos;
      });
      if (known == kKnownNames.end()) {
        others.push_back(part);
      } else {
        found[known->layer].push_back(&part);
      }
    }
    if (found[1].empty() || (found[0].empty() && found[2].empty())) {
      out_.whole = mesh.mesh;
      if (mesh.parts.size() > 1)
        out_.report.push_back("parts of the file, taken together: " + ListOf(mesh.parts));
      return;
    }
    for (size_t layer = 0; layer < kLayers; ++layer) {
      for (const mesh::MeshPart* part : found[layer]) Use(mesh, *part, layer);
    }
    if (!others.empty())
      out_.report.push_back("parts of no known tissue, left out: " + ListOf(others));
  }

  void Use(const mesh::NamedMesh& mesh, const mesh::MeshPart& part, size_t layer) {
    Append(mesh.mesh, part, out_.surfaces[layer]);
    out_.report.push_back(TissueOf(layer) + ": part '" + NameOf(part) + "' of the file");
  }

  // FILE, FILE#PART, or a PART of the one file.
  Status Take(size_t layer, const std::string& source) {
    std::error_code error;
    const size_t hash = source.rfind('#');
    fs::path file = source;
    std::string part;
    // A file of that very name first: '#' may be part of one.
    if (!fs::exists(file, error)) {
      if (hash != std::string::npos && fs::exists(source.substr(0, hash), error)) {
        file = source.substr(0, hash);
        part = source.substr(hash + 1);
      } else if (!sources_.file.empty() && !file.has_parent_path() && !file.has_extension()) {
        file = sources_.file;
        used_file_ = true;
        part = hash == 0 ? source.substr(1) : source;
      }
    }
    Result<const mesh::NamedMesh*> mesh = File(file);
    if (!mesh.ok())
      return Status(mesh.status().code(), TissueOf(layer) + ": " + mesh.status().message(),
                    TissueOf(layer));
    if (part.empty()) {
      out_.surfaces[layer] = (*mesh)->mesh;
      return Status::Ok();
    }
    return TakePart(layer, **mesh, part);
  }

  // All parts of exactly that name, else the only one whose name holds it.
  Status TakePart(size_t layer, const mesh::NamedMesh& mesh, const std::string& wanted) {
    const std::string name = Small(wanted);
    std::vector<const mesh::MeshPart*> same, holding;
    for (const mesh::MeshPart& part : mesh.parts) {
      if (Small(part.name) == name || Small(part.material) == name || Small(NameOf(part)) == name)
        same.push_back(&part);
      if (Small(NameOf(part)).find(name) != std::string::npos) holding.push_back(&part);
    }
    if (same.empty() && holding.size() == 1) same = holding;
    if (same.empty()) {
      return Status(Code::kInvalidInput,
                    TissueOf(layer) + ": expected " + (holding.empty() ? "a" : "one") +
                        " part named '" + Printable(wanted) + "', the file has " +
                        (mesh.parts.empty() ? "none" : ListOf(mesh.parts)),
                    TissueOf(layer));
    }
    for (const mesh::MeshPart* part : same) Use(mesh, *part, layer);
    return Status::Ok();
  }

  const ImportSources& sources_;
  const fs::path& child_;
  std::map<fs::path, mesh::NamedMesh> files_;
  ReadSources out_;
  bool used_file_ = false;  // some tissue is a part of it
};

}  // namespace

Result<ReadSources> Read(const ImportSources& sources, const fs::path& child) {
  return Reader(sources, child).Run();
}

}  // namespace enamel::import
