#include "common/import/mesh_kind.h"

#include <algorithm>

#include "common/import/mesh_text.h"

namespace enamel::import {
namespace {

struct Foreign {
  std::string_view kind;   // of the file's name
  std::string_view begin;  // of its bytes; empty: nothing that is only its own
  std::string_view advice;
};
constexpr std::string_view kExport = ": export the tooth as STL, PLY or OBJ";
constexpr std::array<Foreign, 16> kForeign = {{
    {"3mf", "", "a 3MF file is not read: open it in a mesh program or slicer, and"},
    {"zip", "PK\x03\x04",
     "it is a ZIP archive (as 3MF is, and what laboratories send): unpack it, or open it in the "
     "program that made it, and"},
    {"glb", "glTF", "glTF (GLB) is not read: open it in a mesh program, and"},
    {"gltf", "", "glTF is not read: open it in a mesh program, and"},
    {"dcm", "<HPS",
     "3Shape's DCM is not read: use 'export to STL' in the scanner's program or ask the laboratory "
     "to, or"},
    {"dicom", "", "DICOM images hold no surface: segment the tooth in an imaging program, and"},
    {"step", "ISO-10303", "STEP is not read: open it in a CAD program, and"},
    {"stp", "", "STEP is not read: open it in a CAD program, and"},
    {"iges", "", "IGES is not read: open it in a CAD program, and"},
    {"fbx", "Kaydara FBX", "FBX is not read: open it in a mesh program, and"},
    {"blend", "BLENDER", "Blender's file is not read: open it in Blender, and"},
    {"drc", "DRACO", "Draco is not read: open it in a mesh program, and"},
    {"constructioninfo", "", "exocad's construction file holds no mesh: in exocad,"},
    {"gz", "\x1f\x8b", "it is packed with gzip: unpack it, or"},
    {"7z", "7z\xbc\xaf", "it is a 7-Zip archive: unpack it, or"},
    {"rar", "Rar!", "it is a RAR archive: unpack it, or"},
}};

Status Refused(const Foreign& foreign) {
  return Status(Code::kInvalidInput, std::string(foreign.advice) + std::string(kExport.substr(1)));
}

}  // namespace

Status CheckMeshKind(std::string_view kind) {
  if (std::ranges::find(kMeshKinds, kind) != kMeshKinds.end()) return Status::Ok();
  for (const Foreign& foreign : kForeign) {
    if (kind == foreign.kind) return Refused(foreign);
  }
  return Status(Code::kInvalidInput, "expected a file named .stl, .ply, .obj or .off, found ." +
                                         std::string(kind) + std::string(kExport));
}

Result<std::string> KindInside(ByteView file) {
  std::string_view text = AsText(file);
  if (HasUtf8Mark(file)) text.remove_prefix(kUtf8Mark);
  for (const Foreign& foreign : kForeign) {
    if (!foreign.begin.empty() && text.starts_with(foreign.begin)) return Refused(foreign);
  }
  // After a preamble of 128 bytes.
  if (text.size() > 132 && text.substr(128, 4) == "DICM")
    return Status(Code::kInvalidInput,
                  "it holds DICOM images and no surface: segment the tooth in an imaging program, "
                  "and export it as STL, PLY or OBJ");
  if (StartsWithWord(text.substr(0, 64), "<?xml") || StartsWithWord(text.substr(0, 64), "<hps")) {
    return Status(
        Code::kInvalidInput,
        text.substr(0, 4096).find("<HPS") != text.npos
            ? "3Shape's DCM is not read: use 'export to STL' in the scanner's program, or "
              "ask the laboratory to"
            : "XML is not read" + std::string(kExport));
  }
  if (text.starts_with("ply\n") || text.starts_with("ply\r")) return std::string("ply");
  if (text.starts_with("OFF\n") || text.starts_with("OFF\r")) return std::string("off");
  if (StartsWithWord(text.substr(0, 256), "solid") &&
      text.substr(0, 4096).find("facet") != text.npos)
    return std::string("stl");
  return std::string();
}

}  // namespace enamel::import
