#include "common/import/mesh_reader.h"

#include "common/import/mesh_formats.h"
#include "common/import/mesh_kind.h"

namespace enamel::import {
namespace {

Status ReadKind(ByteView file, const std::string& kind, MeshBuilder& out) {
  if (kind == "stl") return ReadStl(file, out);
  if (kind == "ply") return ReadPly(file, out);
  if (kind == "off") return ReadOff(file, out);
  return ReadObj(file, out);
}

}  // namespace

Result<mesh::NamedMesh> ReadMesh(ByteView file, const std::string& kind) {
  if (file.empty()) return Status(Code::kInvalidInput, "the file is empty");
  ENAMEL_RETURN_IF_ERROR(CheckMeshKind(kind));
  ENAMEL_ASSIGN_OR_RETURN(const std::string inside, KindInside(file));
  MeshBuilder out;
  if (!inside.empty() && inside != kind)
    out.Note("it is named ." + kind + " and read as ." + inside + ", which it holds");
  ENAMEL_RETURN_IF_ERROR(ReadKind(file, inside.empty() ? kind : inside, out));
  return out.Finish();
}

}  // namespace enamel::import
