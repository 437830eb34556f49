#pragma once

#include <filesystem>
#include <vector>

#include "common/math/vec.h"
#include "common/scene/builder.h"

// Distance of a scanned crown from a tooth of ours after the best rigid alignment (rotation and
// translation, no scaling, no mirroring).
namespace enamel::scene {

// A point on a scan's surface and the area it represents, metres.
struct ScanPoint {
  dvec3 position_m, normal;
  double area_m2;
};

struct Scan {
  std::vector<ScanPoint> points;  // one per triangle of the crown proper
  double base_share = 0;          // of the whole area: the plane that closes the scan below the gum
};

// Reads an OBJ in millimetres. `occlusal` is the direction of the cusps in the file. Triangles that
// face away from it by more than 60 degrees close the scan below the gum line, where no tooth is
// seen, and are left out.
Scan ReadScan(const std::filesystem::path& file, const dvec3& occlusal);

struct CrownFit {
  double rms_m = 0, p95_m = 0, max_m = 0;  // scan to tooth, weighted by area
  double back_p95_m = 0;                   // tooth to scan, where the scan has a surface
  std::vector<dvec3> aligned_m;            // the scan's points in the tooth's frame
};

// Aligns by Gauss-Newton on the tooth's signed distance from many turns about the occlusal axis and
// keeps the best. Distances are to the tooth's extracted surface.
CrownFit FitCrown(const Scan& scan, const dvec3& occlusal, const Field& tooth, const dvec3& lo_m,
                  const dvec3& hi_m);

}  // namespace enamel::scene
