#pragma once

#include "station/lab/suites/adversary.h"

// The attacks of adversary.h: each plays a game for so many ticks, or so many rounds of a search,
// and adds what it found. Private to adversary.cpp.
namespace enamel::station::lab {

// Axes turned any way: orthonormal columns.
dmat3 RandomFrame(Random& random);
// One tick of the game, counted in `attack`.
void PlayCounted(Game& game, const Turn& turn, Attack* attack);

// Drawn motions (drawn_attacks.cpp).
void PlayWalk(Game& game, const GameRules& rules, Random& random, int64_t ticks, Attack* attack);
// The tip dithers across an edge of its cell while wall and air alternate in every pattern; all of
// them if they are few, else drawn.
void PlayDither(Game& game, const GameRules& rules, Random& random, int64_t ticks, Attack* attack);
// Presses into something hard, lets go, comes back: with the bound at 0 on the way in and up on the
// way out, and with a jerk outwards in the tick whose force stops before the tip returns unseen.
void PlayPress(Game& game, const GameRules& rules, Random& random, int64_t ticks, Attack* attack);

// Searches (bred_attacks.cpp).
// One parent, one child, the one-fifth rule; half of the children differ in a tick only.
void PlayBred(Game& game, const GameRules& rules, Random& random, int64_t rounds, Attack* attack);
// A small population whose spread per gene follows its best third (a separable evolution strategy).
void PlayPopulation(Game& game, const GameRules& rules, Random& random, int64_t rounds,
                    Attack* attack);

}  // namespace enamel::station::lab
