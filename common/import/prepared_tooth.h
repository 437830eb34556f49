#pragma once

#include <filesystem>
#include <string>

#include "common/import/import_tooth.h"
#include "common/mesh/registration.h"

// Turns the scan of a tooth that a dentist prepared into a target. The scan is laid on the
// exercise's tooth; the target is the part of the tooth that the scan lacks. Not real-time: seconds.
namespace enamel::import {

struct PreparedOptions {
  mesh::FileScale scale = {};  // of the scan's coordinates
  // The scan is already placed within 0.5 mm and 5 degrees: for blocks and other shapes that fit
  // themselves in several ways.
  bool placed = false;
};

// The limits of a fit. A scanner errs by 0.02 mm, and a model by as much; unrelated surfaces that
// cross within kAgree_mm have an RMS of 0.087 mm.
inline constexpr double kMaxRms_mm = 0.07, kMaxP95_mm = 0.14;
inline constexpr double kMaxOutside = 0.05, kMinAgree = 0.2;
// A narrow collar holds a scan too, where it agrees as exactly as only the same tooth does.
inline constexpr double kMinCollar = 0.1, kCollarRms_mm = 0.05, kCollarP95_mm = 0.125,
                        kCollarOutside = 0.005;

struct PreparedTooth {
  // The tooth as it was scanned, on the voxels of the tooth it was made from: its scene is that
  // tooth's, named and described as prepared.
  ImportedScene prepared;
  mesh::Fit fit;  // scene frame, mm
  double removed_mm3 = 0;
};

// The outer surface of a scene's tooth, without neighbours, millimetres.
mesh::Triangles ToothSurface_mm(const cutting::Volume& tooth);

// Whether a fit is good enough to take a target from. `fits`: mesh::FitOnto's. Errors:
// kInvalidInput with the figures that are too bad; where two poses are equally good; where nothing
// agrees.
Status CheckFit(const std::vector<mesh::Fit>& fits);

// Lays the scan, closed where it is open, on `tooth`, and takes off the part of the tooth outside
// the scan: near the prepared surface, where that is deeper than the fit's own error. Elsewhere the
// tooth is unchanged, so that a scanner's noise takes nothing. Nothing is taken outside the edge of
// a scan (a root that it does not have).
// Errors: kInvalidInput when the scan is no solid, is not of a tooth's size, does not fit
// (CheckFit; the message mentions a mirror image that would), has no preparation, or one that a
// hole or the scan's edge crosses.
Result<PreparedTooth> TakePrepared(const scene::Scene& scene, const cutting::Volume& tooth,
                                   const mesh::Triangles& scan, const std::string& source,
                                   const PreparedOptions& options = {});
// The same from a file, read in a child. Errors: ReadMeshInChild's too.
Result<PreparedTooth> TakePrepared(const scene::Scene& scene, const cutting::Volume& tooth,
                                   const std::filesystem::path& file,
                                   const PreparedOptions& options = {},
                                   const std::filesystem::path& child = {});

}  // namespace enamel::import
