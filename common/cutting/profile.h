#pragma once

#include <span>

#include "common/cutting/bur.h"

// A bur's outline in the plane (r, z): distance from the axis and height. Turned about the axis it
// is the bur's body.
namespace enamel::cutting {

// One piece of a convex outline, walked from the axis at the tip, round the outside, to the axis at
// the shank. A line has one outward normal; an arc (radius 0: a corner) those from `first` to
// `last`, counter-clockwise, less than or exactly half a turn. Metres.
//
// The piece's region is where it is the nearest: between the normals at its two ends,
//   region[i][0] r + region[i][1] z >= region[i][2]   for i = 0, 1,
// each a distance to the border, positive inside. A border on the axis is no border.
struct ProfilePiece {
  bool arc = false;
  double first[2]{}, last[2]{};  // unit normals (r, z)
  double at[2]{};                // arc: centre; line: its first point
  double radius = 0;             // arc
  double to[2]{};                // line: its last point
  double region[2][3]{};
};

// Convex outline of at most kMaxPieces pieces. For a convex body the signed distance is the largest
// of n . p - h(n) over its outward normals n, inside and outside (h: support function; Rockafellar,
// Convex Analysis, 1970, section 13), and so the largest over its pieces: a line gives n . (p - a)
// everywhere, an arc |p - c| - R within its region. It is convex, falls by at most its gradient's
// share of a move and needs no case for the medial axis. Immutable.
class Profile {
 public:
  static constexpr int kMaxPieces = 6;

  std::span<const ProfilePiece> pieces() const noexcept { return {pieces_, count_}; }
  // Signed distance of (r, z), r >= 0, in metres, negative inside. Real-time: safe.
  double Distance(double r, double z) const noexcept;

 private:
  friend class ProfileBuilder;
  ProfilePiece pieces_[kMaxPieces];
  size_t count_ = 0;
};

// Requires: IsPossible(bur). Only + - * / sqrt.
Profile ProfileOf(const Bur& bur) noexcept;

}  // namespace enamel::cutting
