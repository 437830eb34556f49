#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

#include "common/cutting/volume.h"
#include "common/scene/types.h"

// The contact with the next tooth, where an acceptable cut R opens it: rows of voxels along x whose outermost kShell_m R
// takes, and 1 mm behind it, up to a neighbour at most kContactGap_m away. A row is closed as far as an attempt left some
// of that shell: what stands farther inside is a pillar, not the contact. R alone fixes the rows, so that more left
// standing only closes more.
//
// Deterministic. Thread safety: const after construction. Not real-time.
namespace enamel::scoring {

// Over the whole face of a molar's contact: its curves are 0.3 mm apart 1.5 mm beside its middle.
inline constexpr double kContactGap_m = 0.3e-3;

class Contact {
 public:
  // A third of one contact, of equal areas: the gingival one, and of the rest the buccal and the lingual half.
  struct Third {
    std::string name;  // "contact_mesial_gingival"
    double rows = 0;
    dvec3 at_m{0};  // its middle, in the shell
  };

  // Requires: equal grids. `tooth`: FDI number, 0: none.
  Contact(const cutting::Volume& initial, const cutting::Volume& prepared, int tooth, scene::Up up);

  // In the order of their names; none where R opens less than 0.1 mm^2 of a contact.
  const std::vector<Third>& thirds() const { return thirds_; }
  size_t row_count() const { return third_.size(); }
  // The row whose shell holds sample `i` of a brick.
  std::optional<uint32_t> RowAt(int brick, int i) const;
  std::optional<uint32_t> ThirdAt(int brick, int i) const;

  // The figures of one third, or of the whole contact.
  struct Figures {
    double rows = 0;
    double closed = 0;  // of them; a row counts less where what was left is thinner than 0.1 mm
    // Rows on which half a voxel more or less would change that, and the most rows at one height.
    double near = 0, longest_line = 0;

    double closed_percent() const { return rows > 0 ? 100 * closed / rows : 0; }
    // Standard, where a surface's place is known to `surface_m` (uncertainty.h).
    double uncertainty_percent(double surface_m, double voxel_m) const;
  };
  // `left_m`: of each row, how much of the shell an attempt left.
  Figures Of(const std::vector<double>& left_m, std::optional<size_t> third = {}) const;
  // Measures the attempt itself.
  Figures Of(const cutting::Volume& attempt) const;

 private:
  struct Row {
    ivec3 end{0};       // the outermost voxel
    int way = 1;        // outwards along x
    int32_t flake = 0;  // what R leaves of that voxel, cutting::SolidFraction
  };
  void FindRows(const cutting::Volume& prepared);
  void TakeRow(const cutting::Volume& prepared, const ivec3& end, int way);
  void Divide(std::vector<uint32_t> rows, const std::string& side, scene::Up up);

  const cutting::Volume& initial_;
  const int shell_;  // voxels
  std::vector<Row> rows_;
  std::vector<uint32_t> third_;  // of each row
  std::vector<Third> thirds_;
  // The row of each sample of a brick, plus 1; 0: none.
  std::unordered_map<int, std::array<uint32_t, cutting::kBrickVoxels>> row_at_;
};

}  // namespace enamel::scoring
