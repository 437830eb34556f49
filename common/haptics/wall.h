#pragma once

namespace enamel::haptics {

// Three times the hardest enamel measured (11.3 N s/mm, Liu et al. 2008): what resists more is a wall,
// or a bur that stalls.
inline constexpr double kWall_n_s_per_m = 34e3;

}  // namespace enamel::haptics
