import { useLayoutEffect, useState } from "preact/hooks";
import type { Playback } from "./playback";

// Draws again whoever calls this when the playback shows another moment. The rest of the page needs no such news: it
// knows the moment that was asked for.
export function useMoves(playback: Playback | undefined): void {
  const [, redraw] = useState(0);
  useLayoutEffect(() => {
    if (playback === undefined) return undefined;
    const moved = () => redraw((count) => count + 1);
    playback.moves.add(moved);
    return () => {
      playback.moves.delete(moved);
    };
  }, [playback]);
}
