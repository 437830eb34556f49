#pragma once

#include <span>
#include <vector>

#include "station/mouth/neck.h"
#include "station/render/mesher.h"

namespace enamel::station::mouth {

// A rubber dam over some teeth in a row, in place of the gingiva: a sheet with a hole for each, whose
// edge is tucked in at the gingival margin. Operative textbooks isolate several teeth for the work on
// one, so that the neighbours' crowns stand through the sheet as well (Sturdevant's Art and Science of
// Operative Dentistry, "Isolation of the operating field"). In the frame of the first tooth, crown
// up, millimetres; `limit_mm` as Gingiva has it. Requires: at least one neck. Not real-time.
std::vector<render::GroupMesh> RubberDam(std::span<const Neck> necks, const Around& limit_mm);

}  // namespace enamel::station::mouth
